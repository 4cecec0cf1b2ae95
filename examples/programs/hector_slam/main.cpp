// Hector-class SLAM on a recorded log: every scan is matched to one map at several resolutions.
// With an inertial unit, scans are levelled and fused with its navigation filter.

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/slam/hector_slam.hpp>

#include "ahrs/recording.hpp"
#include "support/option_fields.hpp"
#include "support/slam_program.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

std::vector<OptionField> fields(HectorSlamOptions& o) {
  return {option_field("cell_m", o.map.finest.resolution_m),
          option_field("levels", o.map.levels),
          option_field("p_free", o.map.model.p_free),
          option_field("p_hit", o.map.model.p_hit),
          option_field("unknown_probability", o.map.unknown_probability),
          option_field("max_iterations", o.match.max_iterations),
          option_field("start_step_deg", o.match.start_step),
          option_field("max_range_m", o.max_range_m),
          option_field("point_spacing_m", o.point_spacing_m),
          option_field("map_travel_m", o.map_travel_m),
          option_field("map_turn_deg", o.map_turn),
          option_field("search_sigmas", o.search_sigmas),
          option_field("independent_points", o.independent_points),
          option_field("least_score", o.min_score),
          option_field("tracked_score", o.tracked_score),
          option_field("lost_score", o.lost_score),
          {"depth_m", [&](double v) { o.level.lowest_m = -v; }, [&] { return -o.level.lowest_m; }},
          option_field("height_m", o.level.highest_m),
          option_field("height_sigma_m", o.carrier.height_sigma_m),
          option_field("speed_sigma_mps", o.carrier.speed_sigma_mps),
          option_field("gyro_white", o.carrier.noise.gyro_white),
          option_field("accel_white", o.carrier.noise.accel_white),
          option_field("gyro_bias_radps", o.carrier.noise.gyro_bias_radps),
          option_field("accel_bias_mps2", o.carrier.noise.accel_bias_mps2)};
}

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
  Facts facts = {{"in the map", std::to_string(s.scans_in_map)}};
  if (fuses) {
    facts.emplace_back("levelled", std::to_string(s.levelled_scans));
    facts.emplace_back("fused", std::to_string(s.fused_scans));
    facts.emplace_back("filter starts", std::to_string(s.carrier_starts));
  }
  return log_run(*slam, std::move(facts));
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
       fields(options), std::bind_front(run, std::cref(options), std::cref(unit)),
       [&] { return check_grid(options.map); },
       [&](CommandLine& app) {
         unit.add_options(app);
         app.add_flag("--no-unit", unit.none, "use no inertial unit, even if LOG has one");
         app.example("robot.log --unit imu.csv --out result", "scans levelled by an inertial unit");
       }});
}
