// Radar against LiDAR in long corridors: the same scan-to-map matching once with each, wheel
// odometry only as the start of each search.

#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "comparison_report.hpp"
#include "drives.hpp"
#include "support/command_line.hpp"
#include "support/exit_code.hpp"
#include "support/program_files.hpp"
#include "support/progress_line.hpp"

namespace {

using namespace wayfare;
using examples::SeedRuns;

struct Options {
  std::string out;
  std::uint64_t first_seed = 1;
  std::size_t seeds = 10;
  examples::DriveOptions drive;
  bool force = false;
  bool quiet = false;
};

Result<std::vector<SeedRuns>> drive_and_match(const Options& o) {
  examples::ProgressLine progress("driving and matching", o.quiet);
  std::vector<SeedRuns> all;
  for (std::size_t i = 0; i < o.seeds; ++i) {
    auto runs = examples::run_seed(o.first_seed + i, o.drive);
    if (!runs) return runs.error();
    all.push_back(std::move(runs).value());
    progress.update(static_cast<double>(i + 1) / static_cast<double>(o.seeds));
  }
  progress.finish();
  return all;
}

Result<void> run(const Options& o) {
  const io::WriteOptions write{o.force ? io::Existing::replace : io::Existing::refuse};
  if (auto ready = examples::prepare_files(o.out, examples::comparison_files(), write); !ready)
    return ready;
  const auto all = drive_and_match(o);
  if (!all) return all.error();
  if (!o.quiet)
    std::printf("%s\n%s\n%s", examples::spread_text(all->front()).c_str(),
                examples::error_table(*all).to_text().c_str(),
                examples::seed_table(*all, o.first_seed).to_text().c_str());
  return examples::write_comparison(*all, {o.out, o.first_seed, write});
}

}  // namespace

int main(int argc, char** argv) {
  examples::CommandLine app(
      "Drive a Turtlebot round a loop of simulated corridors and localise it by scan matching, "
      "once "
      "with its LiDAR and once with its radar; odometry only starts each search.");
  Options o;
  app.add_option("--out", o.out, "folder for report.html and the score pictures").required();
  app.add_option("--seeds", o.seeds, "drives, each in a building of its own")
      .range(1, 1000)
      .show_default();
  app.add_option("--first-seed", o.first_seed, "of the first drive").show_default();
  app.add_option("--frames", o.drive.frames, "radar frames gathered into one scan")
      .range(3, 100)
      .show_default();
  app.add_option("--window", o.drive.window_m, "half the search's width, m")
      .range(0.05, 2.0)
      .show_default();
  app.add_flag("--force", o.force, "replace files that are there already");
  app.add_flag("--quiet", o.quiet, "no progress, no tables");
  if (const auto code = app.parse(argc, argv)) return *code;
  return examples::exit_code("hallway_comparison", run(o));
}
