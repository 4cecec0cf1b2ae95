// Submap SLAM on a walker: steps by an inertial unit are the odometry, and the map corrects them.

#include <string>
#include <utility>

#include <wayfare/eval/table.hpp>
#include <wayfare/slam/pedestrian_slam.hpp>

#include "ahrs/unit_options.hpp"
#include "support/command_line.hpp"
#include "support/log_program.hpp"
#include "support/submap_slam_fields.hpp"

namespace {

using namespace wayfare;

struct Unit : examples::UnitOptions {
  double step_m = 0.0;
  bool no_magnetometer = false, no_steps = false, no_feedback = false, no_heading = false;

  void describe(examples::CommandLine& app) {
    UnitOptions::describe(app);
    app.add_option("--step", step_m, "length of every step, m; else by the steps' strength")
        .positive();
    app.add_flag("--no-magnetometer", no_magnetometer, "no heading by it where the map tells none");
    app.add_flag("--no-steps", no_steps, "take the unit's turns and tilt only");
    app.add_flag("--no-feedback", no_feedback, "leave steps and heading as they are");
    app.add_flag("--no-heading", no_heading,
                 "let the map correct the steps, and not the unit's own heading");
  }

  void apply(PedestrianSlamOptions& o, const examples::UnitReadings& readings,
             const Recording& log) const {
    o.q_unit_laser = q_unit_laser();
    o.pedestrian.forward = forward_axis();
    if (readings.q_base_unit) {
      const double heading = log.T_base_laser.raw().heading().radians();
      o.q_unit_laser = readings.q_base_unit->inverse() * SO3d::exp({0, 0, heading});
      o.pedestrian.forward = o.q_unit_laser * Eigen::Vector3d::UnitX();
    }
    if (step_m > 0) o.pedestrian.length = ConstantStep{step_m};
    o.pedestrian.ahrs.use_magnetometer = !no_magnetometer && readings.file.has_magnetometer;
    o.steps = !no_steps;
    o.feedback = !no_feedback;
    o.heading = !no_heading;
  }
};

Result<examples::LogRun> run(const Recording& recording, PedestrianSlamOptions options,
                             const Unit& unit, const examples::SlamArguments& arguments,
                             const SlamProgress& progress) {
  const auto readings = unit.read(arguments.log, arguments.topics);
  if (!readings) return readings.error();
  if (!*readings)
    return Error{ErrorCode::not_found, "holds no inertial unit: --unit must name one's recording",
                 arguments.log};
  unit.apply(options, **readings, recording);
  options.slam.threads = arguments.threads;
  auto walk = run_pedestrian_slam(recording, (*readings)->file.samples, options, progress);
  if (!walk) return walk.error();
  SubmapSlamRun& slam = walk->slam;
  const SubmapSlamStatistics& s = slam.statistics;
  return examples::LogRun{
      std::move(slam.trajectory),
      std::move(slam.map),
      slam.graph,
      s.scans,
      s.unmatched_scans,
      {{"submaps", std::to_string(s.submaps) + " of " + std::to_string(s.nodes) + " scans"},
       {"loop closures", std::to_string(s.loop_closures) + " accepted, " +
                             std::to_string(s.loops_refused) + " refused"},
       {"steps' scale", eval::fixed(walk->step_scale, 3)}},
      slam.refused_scans,
      slam.first_refusal};
}

}  // namespace

int main(int argc, char** argv) {
  PedestrianSlamOptions options;
  Unit unit;
  return examples::run_log_program(
      argc, argv,
      {"pedestrian_slam", "pedestrian SLAM",
       "Follow a walker who carries a range finder and an inertial unit: submap SLAM with steps "
       "for odometry, corrected by the map; scans are levelled by the unit's attitude.",
       examples::submap_slam_fields(options.slam),
       [&](const Recording& recording, const examples::SlamArguments& arguments,
           const SlamProgress& progress) {
         return run(recording, options, unit, arguments, progress);
       },
       [&] { return examples::check_submap_slam(options.slam); },
       [&](examples::CommandLine& app) { unit.describe(app); }});
}
