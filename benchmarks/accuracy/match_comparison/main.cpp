// Scan matchers on the same pairs of scans of a log: how often each finds the way between them from
// a start that is off by so much, how exactly and how fast.

#include <cstdio>
#include <string>
#include <vector>

#include <wayfare/eval/table.hpp>
#include <wayfare/io/report.hpp>

#include "support/command_line.hpp"
#include "support/exit_code.hpp"
#include "support/program_files.hpp"
#include "support/progress_line.hpp"
#include "support/slam_program.hpp"
#include "trials.hpp"

namespace {

using namespace wayfare;

struct Options : examples::SlamArguments {
  std::size_t pairs = 300;
  double apart_m = 0.5;
};

std::string text_of(const examples::StartError& e) {
  return eval::fixed(e.offset_m, 2) + " m, " + eval::fixed(e.turn.degrees(), 0) + "°";
}

eval::Table success_table(const std::vector<examples::MatcherTrials>& trials,
                          const examples::TrialOptions& options) {
  std::vector<eval::Table::Column> columns{{"found from a start off by"}};
  for (const auto& start : options.starts) columns.push_back({text_of(start)});
  eval::Table table(columns);
  for (const auto& t : trials) {
    std::vector<std::string> row{t.name};
    for (const double s : t.success) row.push_back(eval::fixed(100 * s, 1) + " %");
    table.add_row(row);
  }
  return table;
}

eval::Table cost_table(const std::vector<examples::MatcherTrials>& trials) {
  eval::Table table({{"matcher"},
                     {"median error", "cm"},
                     {"a scan's map", "us"},
                     {"nearest start", "us"},
                     {"farthest start", "us"}});
  for (const auto& t : trials)
    table.add_row({t.name, eval::fixed(100 * t.median_error_m, 2), eval::fixed(t.map_us, 0),
                   eval::fixed(t.microseconds.front(), 0), eval::fixed(t.microseconds.back(), 0)});
  return table;
}

io::Plot plot_of(const std::vector<examples::MatcherTrials>& trials,
                 const examples::TrialOptions& options) {
  io::Plot plot{"Found from a start that far off", "offset [m]", "of the pairs [%]", {}};
  for (const auto& t : trials) {
    io::Series series{t.name, {}, {}, io::Mark::line};
    for (std::size_t k = 0; k < t.success.size(); ++k) {
      series.x.push_back(options.starts[k].offset_m);
      series.y.push_back(100 * t.success[k]);
    }
    plot.series.push_back(series);
  }
  return plot;
}

Result<void> write_report(const Options& o, const std::vector<examples::ScanPair>& pairs,
                          const examples::TrialOptions& options,
                          const std::vector<examples::MatcherTrials>& trials) {
  const eval::Table success = success_table(trials, options), cost = cost_table(trials);
  io::Report report("Scan matchers on " + o.log,
                    std::to_string(pairs.size()) + " pairs of scans, " + eval::fixed(o.apart_m, 2) +
                        " m apart; found: within 10 cm and 2° of graph SLAM's poses");
  report.table(success);
  report.plot(plot_of(trials, options));
  report.table(cost, "Errors from the nearest start; mean times on this machine");
  const std::string path = o.out + "/report.html";
  if (auto ok = report.write(path, o.write()); !ok) return ok;
  if (!o.quiet)
    std::printf("%zu pairs\n\n%s\n%s\nreport: %s\n", pairs.size(), success.to_text().c_str(),
                cost.to_text().c_str(), path.c_str());
  return {};
}

Result<void> run(const Options& o) {
  if (auto ready = examples::prepare_files(o.out, {"report.html"}, o.write()); !ready) return ready;
  const auto recording = examples::read_robot_log(o.log, o.topics);
  if (!recording) return recording.error();
  examples::ProgressLine truth("graph SLAM", o.quiet);
  const auto pairs = examples::pairs_of(*recording, o.pairs, o.apart_m, [&](double fraction) {
    truth.update(fraction);
    return true;
  });
  truth.finish();
  if (!pairs) return pairs.error();
  examples::TrialOptions options;
  options.seed = o.seed;
  examples::ProgressLine line("matching", o.quiet);
  const auto trials =
      examples::run_trials(*pairs, options, [&](double fraction) { line.update(fraction); });
  line.finish();
  return write_report(o, *pairs, options, trials);
}

}  // namespace

int main(int argc, char** argv) {
  examples::CommandLine app{
      "Compares scan matchers on pairs of scans of a recorded log: how often each finds the way "
      "between two scans from a start that is off, how exactly, and how fast. The poses of graph "
      "SLAM are taken for the truth."};
  Options o;
  app.add_option("LOG", o.log, "the recorded log").required().existing_file();
  examples::add_out(app, o, "folder for the report, made where needed");
  app.add_option("--pairs", o.pairs, "pairs of scans, from all over the log")
      .range(1, 100000)
      .show_default();
  app.add_option("--apart", o.apart_m, "travel between the scans of a pair, m")
      .range(0.01, 10.0)
      .show_default();
  examples::add_seed(app, o, "of the starts' directions");
  examples::add_robot_topics(app, o.topics);
  examples::add_manners(app, o);
  if (const auto code = app.parse(argc, argv)) return *code;
  return examples::exit_code("match_comparison", run(o));
}
