#include "hector_slam/option_fields.hpp"

namespace wayfare::examples {

std::vector<OptionField> hector_slam_fields(HectorSlamOptions& o) {
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
          option_field("velocity_search_sigmas", o.velocity_search_sigmas),
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

}  // namespace wayfare::examples
