// Scan matchers on the same pairs of scans of a log: success rate over the error of the initial
// pose, accuracy and time.

#include <cstdio>
#include <string>
#include <vector>

#include "support/progress_line.hpp"
#include "support/slam_program.hpp"
#include "trials.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

struct Options : SlamArguments {
  std::size_t pairs = 300;
  double apart_m = 0.5;
};

std::string text_of(const StartError& e) {
  return eval::fixed(e.offset_m, 2) + " m, " + eval::fixed(e.turn.degrees(), 0) + "°";
}

eval::Table success_table(const std::vector<MatcherTrials>& trials, const TrialOptions& options) {
  std::vector<eval::Table::Column> columns{{"success with initial error"}};
  for (const auto& start : options.starts) columns.push_back({text_of(start)});
  eval::Table table(columns);
  for (const auto& t : trials) {
    std::vector<std::string> row{t.name};
    for (const double s : t.success) row.push_back(eval::fixed(100 * s, 1) + " %");
    table.add_row(row);
  }
  return table;
}

eval::Table cost_table(const std::vector<MatcherTrials>& trials) {
  eval::Table table({{"matcher"},
                     {"median error", "cm"},
                     {"map of a scan", "us"},
                     {"smallest error", "us"},
                     {"largest error", "us"}});
  for (const auto& t : trials)
    table.add_row({t.name, eval::fixed(100 * t.median_error_m, 2), eval::fixed(t.map_us, 0),
                   eval::fixed(t.microseconds.front(), 0), eval::fixed(t.microseconds.back(), 0)});
  return table;
}

io::Plot plot_of(const std::vector<MatcherTrials>& trials, const TrialOptions& options) {
  io::Plot plot{"Success over the error of the initial pose", "offset [m]", "pairs [%]", {}};
  for (const auto& t : trials) {
    io::Series series{t.name, {}, {}, io::Mark::line};
    for (std::size_t k = 0; k < t.success.size(); ++k)
      series.add(options.starts[k].offset_m, 100 * t.success[k]);
    plot.series.push_back(series);
  }
  return plot;
}

Result<void> write_report(const Options& o, const std::vector<ScanPair>& pairs,
                          const TrialOptions& options, const std::vector<MatcherTrials>& trials) {
  const eval::Table success = success_table(trials, options), cost = cost_table(trials);
  io::Report report("Scan matchers on " + o.log,
                    std::to_string(pairs.size()) + " pairs of scans, " + eval::fixed(o.apart_m, 2) +
                        " m apart; success: within 10 cm and 2° of the poses of graph SLAM");
  report.table(success);
  report.plot(plot_of(trials, options));
  report.table(cost, "Errors with the smallest initial error; mean times on this machine");
  const std::string path = o.path("report.html");
  if (auto ok = o.write_report(report); !ok) return ok;
  if (!o.quiet)
    std::printf("%zu pairs\n\n%s\n%s\nreport: %s\n", pairs.size(), success.to_text().c_str(),
                cost.to_text().c_str(), path.c_str());
  return {};
}

Result<void> run(const Options& o) {
  if (auto ready = o.prepare({"report.html"}); !ready) return ready;
  const auto recording = read_robot_log(o.log, o.topics);
  if (!recording) return recording.error();
  ProgressLine truth("graph SLAM", o.quiet);
  const auto pairs = pairs_of(*recording, o.pairs, o.apart_m, std::ref(truth));
  truth.finish();
  if (!pairs) return pairs.error();
  TrialOptions options;
  options.seed = o.seed;
  ProgressLine line("matching", o.quiet);
  const auto trials = run_trials(*pairs, options, std::ref(line));
  line.finish();
  return write_report(o, *pairs, options, trials);
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine app{
      "Compare scan matchers on pairs of scans of a recorded log: success rate over the error of "
      "the initial pose, accuracy and time. The poses of graph SLAM are the reference."};
  Options o;
  app.add_option("LOG", o.log, "the recorded log").required().existing_file();
  add_out(app, o, "folder for the report, created if needed");
  app.add_option("--pairs", o.pairs, "pairs of scans, evenly distributed over the log")
      .range(1, 100000)
      .show_default();
  app.add_option("--apart", o.apart_m, "distance between the scans of a pair, m")
      .range(0.01, 10.0)
      .show_default();
  add_seed(app, o, kSeedHelp);
  add_robot_topics(app, o.topics);
  add_force_and_quiet(app, o);
  add_json(app, o);
  app.example("robot.log --pairs 300 --out matching", "300 pairs of scans");
  if (const auto code = app.parse(argc, argv)) return *code;
  return exit_code("match_comparison", run(o));
}
