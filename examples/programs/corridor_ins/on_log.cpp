#include "on_log.hpp"

#include <utility>

namespace wayfare::examples {

CorridorInsOptions corridor_options_for_logs(bool has_gyro) {
  CorridorInsOptions o;
  o.walls.range_noise_m = 0.015;
  o.walls.flatness_m = 0.01;
  o.walls.split_m = 0.05;
  o.square_sigma_rad = 0.01;
  o.building_sigma_rad = 0.03;
  o.wall_offset_sigma_m = 0.02;
  o.wall_direction_sigma_rad = 0.01;
  o.noise.slip_m_per_sqrt_m = 0.02;
  o.noise.acceleration_sigma_m_s2 = 1e-6;
  o.start_scale = 0.03;
  o.start_bias_rad_s = 0.06;
  o.start_drift_rad_s2 = has_gyro ? 6e-6 : 1e-9;
  o.greatest_acceleration_m_s2 = 20.0;  // the times of odometry are not exact
  o.rest_calibrates = has_gyro;         // odometry at rest has zero yaw rate
  if (!has_gyro) {
    o.noise.angle_random_walk_rad_per_sqrt_s = 0.03;
    o.noise.bias_sigma_rad_s = 1e-5;
    o.gyro_range_rad_s = 20.0;
    o.turn_error = 0.1;
  }
  return o;
}

CorridorInsOptions corridor_options_of(const Recording& r) {
  const bool moves = !r.wheels.empty() || !r.odometry.empty();
  CorridorInsOptions o = corridor_options_for_logs(!r.gyro.empty() && moves);
  o.T_base_laser = r.T_base_laser;
  return o;
}

std::vector<OptionField> corridor_option_fields(CorridorInsOptions& o) {
  return {
      option_field("range_noise_m", o.walls.range_noise_m),
      option_field("flatness_m", o.walls.flatness_m),
      option_field("reach_m", o.walls.max_range_m),
      option_field("split_m", o.walls.split_m),
      option_field("least_support_m", o.walls.min_support_m),
      option_field("least_correlation", o.walls.min_correlation),
      option_field("angle_random_walk_rad_per_sqrt_s", o.noise.angle_random_walk_rad_per_sqrt_s),
      option_field("bias_sigma_rad_s", o.noise.bias_sigma_rad_s),
      option_field("bias_tau_s", o.noise.bias_tau_s),
      option_field("slip_m_per_sqrt_m", o.noise.slip_m_per_sqrt_m),
      option_field("start_bias_rad_s", o.start_bias_rad_s),
      option_field("start_drift_rad_s2", o.start_drift_rad_s2),
      option_field("start_scale", o.start_scale),
      option_field("greatest_acceleration_m_s2", o.greatest_acceleration_m_s2),
      option_field("wall_offset_sigma_m", o.wall_offset_sigma_m),
      option_field("wall_direction_sigma_rad", o.wall_direction_sigma_rad),
      option_field("turn_error", o.turn_error),
      option_field("square_sigma_rad", o.square_sigma_rad),
      option_field("building_sigma_rad", o.building_sigma_rad),
      option_field("tracking_m", o.walls.tracking_m),
      option_field("gate_probability", o.gate_probability)};
}

SignedMotion signed_motion_of(const Recording& recording, DirectionFrom from) {
  auto motion = motion_of(recording);
  const bool by_scans = from == DirectionFrom::scans ||
                        (from == DirectionFrom::automatic && counts_without_sign(motion));
  if (by_scans) return sign_motion(recording, motion);
  return {std::move(motion), 0};
}

Result<CorridorRun> run_corridor_passes(const Recording& recording,
                                        std::span<const MotionSample> motion,
                                        CorridorInsOptions options, int passes,
                                        const std::function<void(double)>& progress) {
  for (int pass = 0;; ++pass) {
    auto run = run_corridor_ins(recording, motion, options, {},
                                [&](double fraction) { progress((pass + fraction) / passes); });
    if (!run || pass + 1 >= passes) return run;
    options.start_bias_value_rad_s = run->epochs.back().gyro_bias.value;
  }
}

}  // namespace wayfare::examples
