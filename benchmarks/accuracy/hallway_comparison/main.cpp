// Radar and LiDAR in long corridors: the same scan-to-map matching with each; wheel odometry gives
// only the start of each search.

#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "comparison_report.hpp"
#include "drives.hpp"
#include "support/progress_line.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

struct Options : OutputArguments {
  std::uint64_t first_seed = 1;
  std::size_t seeds = 10;
  DriveOptions drive;
};

Result<std::vector<SeedRuns>> drive_and_match(const Options& o) {
  ProgressLine progress("driving and matching", o.quiet);
  std::vector<SeedRuns> all;
  for (std::size_t i = 0; i < o.seeds; ++i) {
    auto runs = run_seed(o.first_seed + i, o.drive);
    if (!runs) return runs.error();
    all.push_back(std::move(runs).value());
    progress.update(static_cast<double>(i + 1) / static_cast<double>(o.seeds));
  }
  progress.finish();
  return all;
}

Result<void> run(const Options& o) {
  if (auto ready = o.prepare(comparison_files()); !ready) return ready;
  const auto all = drive_and_match(o);
  if (!all) return all.error();
  if (!o.quiet)
    std::printf("%s\n%s\n%s", spread_text(all->front()).c_str(),
                error_table(*all).to_text().c_str(),
                seed_table(*all, o.first_seed).to_text().c_str());
  return write_comparison(o, *all, o.first_seed);
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine app(
      "Simulate a Turtlebot in a loop of corridors and localise it by scan matching, with its "
      "LiDAR and with its radar; odometry gives only the start of each search.");
  Options o;
  add_out(app, o, "folder for report.html and the score images");
  app.add_option("--seeds", o.seeds, "drives, each in another building")
      .range(1, 1000)
      .show_default();
  app.add_option("--first-seed", o.first_seed, "of the first drive").show_default();
  app.add_option("--frames", o.drive.frames, "radar frames combined into one scan")
      .range(1, 100)
      .show_default();
  app.add_option("--window", o.drive.window_m, "half the width of the search window, m")
      .range(0.05, 2.0)
      .show_default();
  add_force_and_quiet(app, o);
  add_json(app, o);
  app.example("--seeds 5 --out hallway", "five drives");
  if (const auto code = app.parse(argc, argv)) return *code;
  return exit_code("hallway_comparison", run(o));
}
