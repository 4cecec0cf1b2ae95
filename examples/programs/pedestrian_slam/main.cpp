// Submap SLAM of a walker: steps detected by an inertial unit are the odometry, which the map
// corrects.

#include <functional>
#include <string>
#include <utility>

#include <wayfare/eval/table.hpp>
#include <wayfare/slam/pedestrian_slam.hpp>

#include "ahrs/recording.hpp"
#include "pedestrian_slam/walker_options.hpp"
#include "support/command_line.hpp"
#include "support/option_fields.hpp"
#include "support/slam_program.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

struct Unit : UnitOptions {
  WalkerOptions walker;

  void add_options(CommandLine& app) {
    UnitOptions::add_options(app);
    walker.add_options(app);
  }

  Result<void> apply(PedestrianSlamOptions& o, const UnitReadings& readings,
                     const Recording& log) const {
    if (auto ok = walker.apply(o); !ok) return ok;
    o.q_unit_laser = q_unit_laser(readings, log);
    o.pedestrian.forward = forward_axis(readings, log);
    o.pedestrian.ahrs.use_magnetometer &= readings.file.has_magnetometer;
    return {};
  }
};

constexpr const char* kDeadReckoning = "dead_reckoning.tum";

Result<LogRun> run(PedestrianSlamOptions options, const Unit& unit, const Recording& recording,
                   const SlamArguments& arguments, const SlamProgress& progress) {
  const auto readings = unit.read(arguments.log, arguments.topics);
  if (!readings) return readings.error();
  if (!*readings)
    return Error{ErrorCode::not_found, "contains no inertial unit: --unit must name its recording",
                 arguments.log};
  if (auto ok = unit.apply(options, **readings, recording); !ok) return ok.error();
  options.slam.threads = arguments.threads;
  auto walk = run_pedestrian_slam(recording, (*readings)->file.samples, options, progress);
  if (!walk) return walk.error();
  SubmapSlamRun& slam = walk->slam;
  const SubmapSlamStatistics& s = slam.statistics;
  Facts facts = {
      {"submaps", std::to_string(s.submaps) + " of " + std::to_string(s.nodes) + " scans"},
      {"loop closures", accepted_and_refused(s.loop_closures, s.loops_refused)},
      {"steps' scale", eval::fixed(walk->step_scale, 3)}};
  LogRun result = log_run_of_pieces(slam, std::move(facts));
  result.others = {{"dead reckoning", kDeadReckoning, std::move(walk->dead_reckoning)}};
  return result;
}

}  // namespace

int main(int argc, char** argv) {
  PedestrianSlamOptions options;
  Unit unit;
  return run_log_program(
      argc, argv,
      {"pedestrian_slam",
       "pedestrian SLAM",
       "Estimate trajectory and map of a walker with range finder and inertial unit: submap SLAM "
       "with steps as odometry, corrected by the map; scans are levelled by the unit's attitude. "
       "Also writes dead_reckoning.tum: the odometry, with the map's corrections so far.",
       submap_slam_fields(options.slam),
       std::bind_front(run, std::cref(options), std::cref(unit)),
       [&] { return check_submap_slam(options.slam); },
       [&](CommandLine& app) {
         unit.add_options(app);
         app.example("walk.log --unit unit.csv --height 1.75 --length frequency --out walk",
                     "steps of a person of 1.75 m");
       },
       {kDeadReckoning}});
}
