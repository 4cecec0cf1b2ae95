#include "nav/corridor_ins/motion_watch.hpp"

#include <algorithm>
#include <cmath>

#include <wayfare/core/geodesy.hpp>

namespace wayfare::corridor {

void MotionWatch::check_wheels(const MotionSample& sample, Duration step, Checked& checked) {
  const double dt = to_seconds(step);
  // Braking during wheel spin is not measured: lower speeds are accepted sooner after longer spin.
  const double gain = sample.speed_m_s - speed_m_s_;
  const double slipping_s = gain < 0.0 ? to_seconds(slipping_) : 0.0;
  const bool jumps = std::abs(gain) > options_.greatest_acceleration_m_s2 * (dt + 0.2 * slipping_s);
  const bool was_slipping = slipping_ > Duration::zero();
  checked.slipping = jumps && slipping_ < options_.longest_slip;
  checked.slip_began = checked.slipping && !was_slipping;
  slipping_ = checked.slipping ? slipping_ + step : Duration::zero();
  if (checked.slipping) {
    checked.input.speed_m_s = speed_m_s_;
    checked.input.extra_distance_m = (0.1 + 0.5 * std::abs(speed_m_s_)) * std::sqrt(dt);
  }
}

MotionWatch::Checked MotionWatch::check(const MotionSample& sample, Duration step) {
  Checked checked;
  CorridorInput& input = checked.input;
  input.dt_s = to_seconds(step);
  const double earth = wgs84::kEarthRate_radps * std::sin(options_.latitude_rad);
  input.turn_rate_rad_s = sample.turn_rate_rad_s - earth;
  input.speed_m_s = sample.speed_m_s;
  input.speed_before_m_s = speed_m_s_;
  input.extra_turn_rad = options_.turn_error * std::abs(input.turn_rate_rad_s) * input.dt_s;
  checked.saturated = std::abs(sample.turn_rate_rad_s) >= 0.999 * options_.gyro_range_rad_s;
  // A saturated gyro gives only a lower bound of the rate.
  if (checked.saturated) input.extra_turn_rad = 0.5 * options_.gyro_range_rad_s * input.dt_s;
  check_wheels(sample, step, checked);
  standing_ = sample.speed_m_s == 0.0 ? standing_ + step : Duration::zero();
  input.at_rest = standing_ >= options_.rest_after && options_.rest_calibrates;
  speed_m_s_ = input.speed_m_s;
  return checked;
}

}  // namespace wayfare::corridor
