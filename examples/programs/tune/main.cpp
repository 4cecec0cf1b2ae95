// Tunes the navigation filter's 33 parameters on drives with known truth by a genetic algorithm.

#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <wayfare/tune/ins_genes.hpp>

#include "cmaes.hpp"
#include "findings.hpp"
#include "ranks.hpp"
#include "support/command_line.hpp"
#include "support/exit_code.hpp"
#include "support/program_files.hpp"
#include "support/progress_line.hpp"

namespace {

using namespace wayfare;
using Clock = std::chrono::steady_clock;

volatile std::sig_atomic_t stop_asked = 0;
extern "C" void ask_to_stop(int) { stop_asked = 1; }

struct Options {
  std::vector<std::string> training, test;
  std::string out, nominal;
  GeneticOptions genetic;
  InsFitnessOptions fitness;
  InsGeneSpans spans;
  std::size_t runs = 1, cmaes = 0;
  bool resume = false, force = false, quiet = false, no_outages = false;
};

constexpr const char* kTuned = "tuned.json";
constexpr const char* kTables = "tables.txt";
constexpr const char* kReport = "report.html";

std::string in(const Options& o, const std::string& name) {
  return (std::filesystem::path(o.out) / name).string();
}

Result<void> prepare(const Options& o, bool first) {
  if (!first) return {};
  std::vector<std::string> names = {kTuned, kTables, kReport};
  if (!o.resume)
    for (std::size_t r = 0; r < o.runs; ++r) names.push_back(examples::checkpoint_name(r));
  const bool replace = o.force || o.resume;
  return examples::prepare_files(o.out, names,
                                 {replace ? io::Existing::replace : io::Existing::refuse});
}

Result<std::vector<examples::LoadedDrive>> load(const std::vector<std::string>& folders,
                                                std::uint64_t first_seed) {
  std::vector<examples::LoadedDrive> drives;
  for (const std::string& folder : folders) {
    auto drive = examples::load_drive(folder, first_seed + drives.size());
    if (!drive) return drive.error();
    drives.push_back(*std::move(drive));
  }
  return drives;
}

/// The noise to start from: a file's, or that of the first training drive's description.
Result<GnssInsOptions> nominal_of(const Options& o, const examples::LoadedDrive& training) {
  if (o.nominal.empty()) return training.config.filter;
  const auto config = examples::read_nav_config(o.nominal);
  if (!config) return config.error();
  return with_ins_genes(training.config.filter, ins_genes(config->filter));
}

/// One line a generation, and within it how far it is and how long the whole will take.
class Watch {
 public:
  Watch(const Options& o, bool quiet) : options_(o), quiet_(quiet), line_("tuning", quiet) {}

  void within(double fraction) {
    const double generations = static_cast<double>(options_.runs * options_.genetic.generations);
    line_.update((static_cast<double>(done_) + fraction) / generations);
  }
  void told(std::size_t run, const GeneticState& state) {
    done_ = run * options_.genetic.generations + state.generation();
    if (quiet_) return;
    const GenerationSummary& s = state.history.back();
    std::printf("run %zu generation %zu: best %.6f mean %.4f failed %zu\n", run + 1,
                state.generation(), s.best, s.mean, s.failed);
    std::fflush(stdout);
  }
  void finish() { line_.finish(); }

 private:
  const Options& options_;
  bool quiet_;
  std::size_t done_ = 0;
  examples::ProgressLine line_;
};

examples::DriveFinding find(const Options& o, const examples::LoadedDrive& drive, bool training,
                            const std::vector<double>& nominal, const std::vector<double>& tuned) {
  examples::DriveFinding f;
  f.name = drive.name;
  f.training = training;
  const GnssInsOptions before = with_ins_genes(drive.config.filter, nominal);
  const GnssInsOptions after = with_ins_genes(drive.config.filter, tuned);
  f.nominal = examples::system_errors(drive, before);
  f.tuned = examples::system_errors(drive, after);
  if (training || o.no_outages) return f;
  auto outages_before = examples::outages(drive, before, o.fitness.threads);
  auto outages_after = examples::outages(drive, after, o.fitness.threads);
  if (outages_before && outages_after) {
    f.nominal_outages = *std::move(outages_before);
    f.tuned_outages = *std::move(outages_after);
  } else {
    const Error& e = outages_before ? outages_after.error() : outages_before.error();
    std::fprintf(stderr, "note: no outages on %s: %s\n", drive.name.c_str(), e.to_string().c_str());
  }
  return f;
}

Result<void> write(const Options& o, const examples::TuneFindings& f,
                   const examples::NavConfig& config) {
  const io::WriteOptions writing{io::Existing::replace};
  examples::NavConfig tuned = config;
  tuned.filter = f.tuned;
  tuned.note = "tuned on " + f.drives.front().name;
  std::string text;
  for (const auto& [name, value] : f.facts) text += name + ": " + value + "\n";
  for (const auto& [title, table] : examples::tables_of(f))
    text += "\n" + title + "\n" + table.to_text();
  if (auto done = io::write_file(in(o, kTuned), examples::format_nav_config(tuned), writing); !done)
    return done;
  if (auto done = io::write_file(in(o, kTables), text, writing); !done) return done;
  if (auto done =
          examples::report_of(f, "Tuning the navigation filter").write(in(o, kReport), writing);
      !done)
    return done;
  if (!o.quiet) std::printf("\n%s\nreport: %s\n", text.c_str(), in(o, kReport).c_str());
  return {};
}

Result<void> run(const Options& o, const examples::Ranks& ranks) {
  if (auto ready = prepare(o, ranks.first()); !ready) return ready;
  auto training = load(o.training, 1);
  if (!training) return training.error();
  auto test = load(o.test, 1 + o.training.size());
  if (!test) return test.error();
  const auto nominal = nominal_of(o, training->front());
  if (!nominal) return nominal.error();

  std::vector<InsFitness> each;
  for (const examples::LoadedDrive& d : *training) {
    auto fitness = InsFitness::make(d.tuning, o.fitness);
    if (!fitness) return Error{fitness.error().code, fitness.error().message, d.name};
    each.push_back(*std::move(fitness));
  }
  const std::string kernel = each.front().kernel();
  Watch watch(o, o.quiet || !ranks.first());
  examples::DrivesFitness drives(std::move(each));
  drives.progress = [&watch](double f) { watch.within(f); };
  const BatchFitness alone = [&drives](auto x, auto scores) { drives(x, scores); };
  const BatchFitness fitness = ranks.share(alone);
  const std::vector<double> nominal_genes = ins_genes(*nominal);
  examples::SearchHooks hooks;
  hooks.stop = [&ranks] { return ranks.any(stop_asked != 0); };
  hooks.told = [&watch](std::size_t r, const GeneticState& s) { watch.told(r, s); };

  std::signal(SIGINT, ask_to_stop);
  std::signal(SIGTERM, ask_to_stop);
  const auto begin = Clock::now();
  auto found = examples::search({o.out, o.runs, o.resume, ranks.first()},
                                ins_gene_bounds(*nominal, o.spans), o.genetic, fitness, {}, hooks);
  if (!found) return found.error();
  const std::chrono::duration<double> took = Clock::now() - begin;
  watch.finish();
  // What is left can be cut short: all generations are saved.
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
  if (!ranks.first()) return {};
  if (!found->complete) {
    std::printf("stopped; everything so far is in %s, --resume goes on\n", o.out.c_str());
    return {};
  }

  examples::TuneFindings f;
  f.nominal = *nominal;
  char text[160];
  drives.progress = {};
  const std::size_t best = found->best();
  std::vector<double> tuned = found->searches[best].best(found->runs[best]);
  double tuned_score = found->runs[best].scores.front();
  if (o.cmaes > 0) {
    const auto further = examples::cmaes(found->searches[best], found->runs[best], o.cmaes, alone);
    if (!further) return further.error();
    std::snprintf(text, sizeof text, "%.4f after %zu evaluations more", further->score,
                  further->evaluations);
    tuned = further->best;
    tuned_score = further->score;
    f.facts.emplace_back("fitness by CMA-ES", text);
  }
  f.tuned = with_ins_genes(*nominal, tuned);
  alone(nominal_genes, {&f.nominal_score, 1});
  std::snprintf(text, sizeof text, "%zu individuals, %zu generations, %zu runs",
                o.genetic.population, o.genetic.generations, o.runs);
  f.facts.emplace_back("search", text);
  std::snprintf(text, sizeof text, "%.1f s, %d threads, %d processes, %s", took.count(),
                o.fitness.threads, ranks.count(), kernel.c_str());
  f.facts.emplace_back("time of the search", text);
  std::snprintf(text, sizeof text, "%.4f nominal, %.4f tuned", f.nominal_score, tuned_score);
  f.facts.emplace_back("fitness", text);
  for (const auto& d : *training) f.drives.push_back(find(o, d, true, nominal_genes, tuned));
  for (const auto& d : *test) f.drives.push_back(find(o, d, false, nominal_genes, tuned));
  f.search = *std::move(found);
  return write(o, f, training->front().config);
}

void add_options(examples::CommandLine& app, Options& o) {
  const auto folders = [&](const char* name, auto& value, const char* text) {
    return app.add_option(name, value, text).existing_folder().expected(1, 64);
  };
  folders("--training", o.training, "drives to tune on: imu.txt, ranges.txt, truth.txt").required();
  folders("--test", o.test, "drives to try the outcome on");
  app.add_option("--out", o.out, "folder for the results, made where needed").required();
  app.add_option("--nominal", o.nominal, "parameters to start from, as allan writes them")
      .existing_file();
  const auto count = [&](const char* name, auto& value, double least, const char* text) {
    app.add_option(name, value, text).range(least, 1e7).show_default();
  };
  count("--population", o.genetic.population, 4, "individuals");
  count("--generations", o.genetic.generations, 1, "generations");
  count("--runs", o.runs, 1, "independent runs; the best of them is taken");
  count("--seed", o.genetic.seed, 0, "of the first run; each further one has the next");
  count("--span", o.spans.noise, 1, "how far noise may be from nominal, times");
  count("--span-tau", o.spans.tau, 1, "the same of correlation times");
  count("--threads", o.fitness.threads, 1, "worker threads; the results do not depend on them");
  InsFitnessWeights& w = o.fitness.weights;
  for (const auto& [name, value] : {std::pair("--weight-position", &w.north)})
    app.add_option(name, *value, "weight of each metre").not_negative();
  app.add_option("--weight-heading", w.heading, "weight of each degree of heading")
      .not_negative()
      .show_default();
  app.add_option("--kernel", o.fitness.kernel, "avx512, avx2 or baseline; by default the widest");
  count("--cmaes", o.cmaes, 0,
        "so many evaluations of CMA-ES from the best of the search (needs pagmo; one at a time)");
  app.add_flag("--resume", o.resume, "go on from the checkpoints in --out");
  app.add_flag("--no-outages", o.no_outages, "leave the outage tables out");
  app.add_flag("--force", o.force, "replace files of an earlier run");
  app.add_flag("--quiet", o.quiet, "no progress and no tables");
}

}  // namespace

int main(int argc, char** argv) {
  const examples::Ranks ranks(&argc, &argv);
  examples::CommandLine app(
      "Tune the navigation filter on drives with known truth by a genetic algorithm.\nEvery "
      "generation is saved: Ctrl-C ends after the one that runs, --resume goes on. mpirun -n N "
      "shares\nthe work among N processes. Writes tuned.json, tables.txt and report.html.");
  Options o;
  o.genetic.elite = 0;  // 0: a fiftieth of the population
  o.fitness.threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  add_options(app, o);
  if (const auto code = app.parse(argc, argv)) return *code;
  o.genetic.elite = std::max<std::size_t>(1, o.genetic.population / 50);
  o.fitness.weights.east = o.fitness.weights.down = o.fitness.weights.north;
  const int code = examples::exit_code("tune", run(o, ranks));
  if (code != 0) ranks.abort(code);
  return code;
}
