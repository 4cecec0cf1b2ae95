// Tunes the navigation filter's 33 parameters on drives with known truth by a genetic algorithm.

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <wayfare/tune/ins_fitness.hpp>

#include "cmaes.hpp"
#include "findings.hpp"
#include "ranks.hpp"
#include "support/progress_line.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

volatile std::sig_atomic_t stop_requested = 0;
extern "C" void request_stop(int) { stop_requested = 1; }

struct Options : OutputArguments {
  std::vector<std::string> training, test;
  std::string nominal;
  GeneticOptions genetic;
  InsFitnessOptions fitness;
  InsGeneSpans spans;
  std::size_t runs = 1, cmaes = 0;
  bool resume = false, no_outages = false;
};

constexpr const char* kTuned = "tuned.json";
constexpr const char* kTables = "tables.txt";
constexpr const char* kReport = "report.html";

Result<void> prepare(const Options& o, bool first) {
  if (!first) return {};
  std::vector<std::string> names = {kTuned, kTables, kReport};
  if (!o.resume)
    for (std::size_t r = 0; r < o.runs; ++r) names.push_back(checkpoint_name(r));
  if (auto ready = o.prepare_json(); !ready) return ready;
  const bool replace = o.force || o.resume;
  return prepare_files(o.out, names, {replace ? io::Existing::replace : io::Existing::refuse});
}

Result<std::vector<LoadedDrive>> load(const std::vector<std::string>& folders,
                                      std::uint64_t first_seed) {
  std::vector<LoadedDrive> drives;
  for (const std::string& folder : folders) {
    auto drive = load_drive(folder, first_seed + drives.size());
    if (!drive) return drive.error();
    drives.push_back(*std::move(drive));
  }
  return drives;
}

/// Nominal noise: from a file, else from the configuration of the first training drive.
Result<GnssInsOptions> nominal_of(const Options& o, const LoadedDrive& training) {
  if (o.nominal.empty()) return training.config.filter;
  const auto config = read_nav_config(o.nominal);
  if (!config) return config.error();
  return with_ins_genes(training.config.filter, ins_genes(config->filter));
}

/// Prints a line per generation and the progress of the whole search.
class Monitor {
 public:
  Monitor(const Options& o, bool quiet) : options_(o), quiet_(quiet), line_("tuning", quiet) {}

  void update(double fraction) {
    const double generations = static_cast<double>(options_.runs * options_.genetic.generations);
    line_.update((static_cast<double>(done_) + fraction) / generations);
  }
  void after_generation(std::size_t run, const GeneticState& state) {
    done_ = run * options_.genetic.generations + state.generation();
    if (quiet_) return;
    const GenerationSummary& s = state.history.back();
    std::printf("run %zu generation %zu: best %.6f mean %.4f failed %zu\n", run + 1,
                state.generation(), s.best, s.mean, s.failed);
    std::fflush(stdout);
  }
  double finish() { return line_.finish(); }

 private:
  const Options& options_;
  bool quiet_;
  std::size_t done_ = 0;
  ProgressLine line_;
};

DriveFinding evaluate(const Options& o, const LoadedDrive& drive, bool training,
                      const std::vector<double>& nominal, const std::vector<double>& tuned) {
  DriveFinding f;
  f.name = drive.name;
  f.training = training;
  const GnssInsOptions before = with_ins_genes(drive.config.filter, nominal);
  const GnssInsOptions after = with_ins_genes(drive.config.filter, tuned);
  f.nominal = system_errors(drive, before);
  f.tuned = system_errors(drive, after);
  if (training || o.no_outages) return f;
  auto outages_before = outages(drive, before, o.fitness.threads);
  auto outages_after = outages(drive, after, o.fitness.threads);
  if (outages_before && outages_after) {
    f.nominal_outages = *std::move(outages_before);
    f.tuned_outages = *std::move(outages_after);
  } else {
    const Error& e = outages_before ? outages_after.error() : outages_before.error();
    std::fprintf(stderr, "note: no outages on %s: %s\n", drive.name.c_str(), e.to_string().c_str());
  }
  return f;
}

Result<void> write(const Options& o, const TuneFindings& f, const NavConfig& config) {
  OutputArguments to = o;
  to.force = true;  // prepare() has looked
  const io::WriteOptions writing = to.write();
  NavConfig tuned = config;
  tuned.filter = f.tuned;
  tuned.note = "tuned on " + f.drives.front().name;
  std::string text;
  for (const auto& [name, value] : f.facts) text += name + ": " + value + "\n";
  text += to_text(tables_of(f));
  const auto done = first_error({io::write_file(o.path(kTuned), format_nav_config(tuned), writing),
                                 io::write_file(o.path(kTables), text, writing),
                                 to.write_report(report_of(f, "Tuning the navigation filter"))});
  if (!done) return done;
  if (!o.quiet) std::printf("\n%s\nreport: %s\n", text.c_str(), o.path(kReport).c_str());
  return {};
}

Result<void> run(const Options& o, const Ranks& ranks) {
  if (auto ready = prepare(o, ranks.first()); !ready) return ready;
  auto training = load(o.training, 1);
  if (!training) return training.error();
  auto test = load(o.test, 1 + o.training.size());
  if (!test) return test.error();
  const auto nominal = nominal_of(o, training->front());
  if (!nominal) return nominal.error();

  std::vector<InsFitness> each;
  for (const LoadedDrive& d : *training) {
    auto fitness = InsFitness::make(d.tuning, o.fitness);
    if (!fitness) return Error{fitness.error().code, fitness.error().message, d.name};
    each.push_back(*std::move(fitness));
  }
  const std::string kernel = each.front().kernel();
  Monitor monitor(o, o.quiet || !ranks.first());
  DrivesFitness drives(std::move(each));
  drives.progress = [&monitor](double f) { monitor.update(f); };
  const BatchFitness alone = [&drives](auto x, auto scores) { drives(x, scores); };
  const BatchFitness fitness = ranks.share(alone);
  const std::vector<double> nominal_genes = ins_genes(*nominal);
  SearchHooks hooks;
  hooks.stop = [&ranks] { return ranks.any(stop_requested != 0); };
  hooks.after_generation = [&monitor](std::size_t r, const GeneticState& s) {
    monitor.after_generation(r, s);
  };

  std::signal(SIGINT, request_stop);
  std::signal(SIGTERM, request_stop);
  auto found = search({o.out, o.runs, o.resume, ranks.first()}, ins_gene_bounds(*nominal, o.spans),
                      o.genetic, fitness, hooks);
  if (!found) return found.error();
  const double took_s = monitor.finish();
  // All generations are saved: the rest can be interrupted.
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
  if (!ranks.first()) return {};
  if (!found->complete) {
    std::printf("stopped; the results so far are in %s, --resume continues\n", o.out.c_str());
    return {};
  }

  TuneFindings f;
  f.nominal = *nominal;
  char text[160];
  drives.progress = {};
  const std::size_t best = found->best();
  std::vector<double> tuned = found->searches[best].best(found->runs[best]);
  double tuned_score = found->runs[best].scores.front();
  if (o.cmaes > 0) {
    const auto further = cmaes(found->searches[best], found->runs[best], o.cmaes, alone);
    if (!further) return further.error();
    std::snprintf(text, sizeof text, "%.4f after %zu further evaluations", further->score,
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
  std::snprintf(text, sizeof text, "%.1f s, %d threads, %d processes, %s", took_s,
                o.fitness.threads, ranks.count(), kernel.c_str());
  f.facts.emplace_back("time of the search", text);
  std::snprintf(text, sizeof text, "%.4f nominal, %.4f tuned", f.nominal_score, tuned_score);
  f.facts.emplace_back("fitness", text);
  for (const auto& d : *training) f.drives.push_back(evaluate(o, d, true, nominal_genes, tuned));
  for (const auto& d : *test) f.drives.push_back(evaluate(o, d, false, nominal_genes, tuned));
  f.search = *std::move(found);
  return write(o, f, training->front().config);
}

void add_options(CommandLine& app, Options& o) {
  const auto folders = [&](const char* name, auto& value, const char* text) {
    return app.add_option(name, value, text).existing_folder().expected(1, 64);
  };
  folders("--training", o.training, "drives to tune on: imu.txt, ranges.txt, truth.txt").required();
  folders("--test", o.test, "drives to evaluate the result on");
  add_out(app, o);
  app.add_file("--nominal", o.nominal, "nominal parameters, as allan writes them");
  const auto count = [&](const char* name, auto& value, double least, const char* text) {
    app.add_number(name, value, least, 1e7, text);
  };
  count("--population", o.genetic.population, 4, "individuals");
  count("--generations", o.genetic.generations, 1, "generations");
  count("--runs", o.runs, 1, "independent runs, of which the best is used");
  count("--tournament", o.genetic.tournament, 0,
        "individuals of a tournament, whose best is a parent; 0: selection by rank");
  const auto number = [&](const char* name, double& value, double least, double most,
                          const char* text) { app.add_number(name, value, least, most, text); };
  number("--selection-pressure", o.genetic.selection_pressure, 1.0, 2.0,
         "of the best over the median individual, for selection by rank");
  number("--crossover-rate", o.genetic.crossover_rate, 0.0, 1.0, "part of the children");
  number("--mutation-rate", o.genetic.mutation_rate, 0.0, 1.0, "part of the genes");
  number("--mutation-sigma", o.genetic.mutation_sigma, 0.0, 1.0,
         "standard deviation of a mutation, part of the gene's range");
  count("--seed", o.genetic.seed, 0,
        "of the random numbers, for the first run; incremented for each further one");
  count("--span", o.spans.noise, 1, "largest factor between noise and its nominal value");
  count("--span-tau", o.spans.tau, 1, "the same for correlation times");
  count("--threads", o.fitness.threads, 1, kThreadsHelp);
  InsFitnessWeights& w = o.fitness.weights;
  app.add_option("--weight-position", w.north, "weight of each metre").not_negative();
  const auto weight = [&](const char* name, double& value, const char* text) {
    app.add_option(name, value, text).not_negative().show_default();
  };
  weight("--weight-roll", w.roll, "weight of each degree of roll");
  weight("--weight-pitch", w.pitch, "weight of each degree of pitch");
  weight("--weight-heading,--weight-yaw", w.heading, "weight of each degree of heading");
  app.add_flag(
      "--covariance-every-step", o.fitness.covariance_every_step,
      "propagate the covariance at every reading, not once between two epochs: three times "
      "as long, scores differ by about a millionth");
  app.add_option("--kernel", o.fitness.kernel,
                 "avx512, avx2 or baseline; by default the widest supported");
  count("--cmaes", o.cmaes, 0,
        "evaluations of CMA-ES, started from the best of the search (needs pagmo; sequential)");
  app.add_flag("--resume", o.resume, "continue from the checkpoints in --out");
  app.add_flag("--no-outages", o.no_outages, "omit the outage tables");
  add_force_and_quiet(app, o);
  add_json(app, o);
}

}  // namespace

int main(int argc, char** argv) {
  const Ranks ranks(&argc, &argv);
  CommandLine app(
      "Tune the navigation filter on drives with known truth by a genetic algorithm.\nEvery "
      "generation is saved: Ctrl-C stops after the current one, --resume continues. mpirun -n N "
      "shares the work among N processes. Writes tuned.json, tables.txt and report.html.");
  Options o;
  o.genetic.elite = 0;  // 0: a fiftieth of the population
  o.fitness.threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  add_options(app, o);
  app.example("--training drive1 drive2 --test drive3 --out tuned",
              "tunes on two drives, evaluates on a third");
  app.example("--training drive1 --out tuned --resume", "continues after Ctrl-C");
  if (const auto code = app.parse(argc, argv)) return *code;
  o.genetic.elite = std::max<std::size_t>(1, o.genetic.population / 50);
  o.fitness.weights.east = o.fitness.weights.down = o.fitness.weights.north;
  const int code = exit_code("tune", run(o, ranks));
  if (code != 0) ranks.abort(code);
  return code;
}
