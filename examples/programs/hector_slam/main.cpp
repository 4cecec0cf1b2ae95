// Hector-class SLAM on a recorded log: every scan is matched to one map at several resolutions.
// With an inertial unit, scans are levelled and fused with its navigation filter.

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/slam/hector_slam.hpp>

#include "ahrs/recording.hpp"
#include "hector_slam/option_fields.hpp"
#include "support/slam_doubt.hpp"
#include "support/slam_program.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

Result<LogRun> run(HectorSlamOptions options, const UnitOptions& unit, const Recording& recording,
                   const SlamArguments& arguments, const SlamProgress& progress) {
  const auto readings = unit.read(arguments.log, arguments.topics);
  if (!readings) return readings.error();
  const bool fuses = readings->has_value();
  if (fuses) options.q_base_unit = unit.q_base_unit(**readings, recording);
  auto slam = run_hector_slam(recording, fuses ? (*readings)->file.samples : MargRecording(),
                              options, progress);
  if (!slam) return slam.error();
  const HectorStatistics& s = slam->statistics;
  const double mebibytes = static_cast<double>(slam->memory_bytes) / (1 << 20);
  Facts facts = {{"in the map", std::to_string(s.scans_in_map)},
                 {"memory", eval::fixed(mebibytes, 1) + " MiB"}};
  if (fuses) {
    facts.emplace_back("levelled", std::to_string(s.levelled_scans));
    facts.emplace_back("fused", std::to_string(s.fused_scans));
    facts.emplace_back("filter starts", std::to_string(s.carrier_starts));
  }
  LogRun result = log_run(*slam, std::move(facts));
  // There are no loop closures: what the robot passes twice is a little beside itself in a good
  // map.
  constexpr double kMostCrossing = 0.1, kMostOfStretch = 0.35;
  Doubt doubt;
  doubt_leaps(doubt, recording);
  doubt_gaps(doubt, recording);
  doubt_walls(doubt, slam->crossings, kMostCrossing, kMostOfStretch);
  result.doubt = doubt.why;
  return result;
}

}  // namespace

int main(int argc, char** argv) {
  HectorSlamOptions options;
  UnitOptions unit;
  return run_log_program(
      argc, argv,
      {"hector_slam", "Hector SLAM",
       "Estimate trajectory and map from a recorded log by matching each scan to one map at "
       "several resolutions; no loop closures. With an inertial unit beside the range finder "
       "(--unit, or "
       "in LOG itself) scans are levelled, and its navigation filter predicts the pose of each.",
       hector_slam_fields(options), std::bind_front(run, std::cref(options), std::cref(unit)),
       [&] { return check_grid(options.map); },
       [&](CommandLine& app) {
         unit.add_options(app);
         app.add_flag("--no-unit", unit.none, "use no inertial unit, even if LOG has one");
         app.example("robot.log --unit imu.csv --out result", "scans levelled by an inertial unit");
       }});
}
