#include "nav/corridor_ins/motion_watch.hpp"

#include <algorithm>
#include <cmath>

#include <wayfare/core/geodesy.hpp>

namespace wayfare::corridor {

void MotionWatch::judge_wheels(const MotionSample& sample, Duration step, Judged& judged) {
  const double dt = to_seconds(step);
  // While wheels spin the vehicle may brake unseen: a lower speed is believed the sooner the longer
  // they have spun.
  const double gain = sample.speed_m_s - speed_m_s_;
  const double held_s = gain < 0.0 ? to_seconds(slipping_) : 0.0;
  const bool jumps = std::abs(gain) > options_.greatest_acceleration_m_s2 * (dt + 0.2 * held_s);
  const bool was_slipping = slipping_ > Duration::zero();
  judged.slipping = jumps && slipping_ < options_.longest_slip;
  judged.slip_began = judged.slipping && !was_slipping;
  slipping_ = judged.slipping ? slipping_ + step : Duration::zero();
  if (judged.slipping) {
    judged.input.speed_m_s = speed_m_s_;
    judged.input.extra_distance_m = (0.1 + 0.5 * std::abs(speed_m_s_)) * std::sqrt(dt);
  }
}

MotionWatch::Judged MotionWatch::judge(const MotionSample& sample, Duration step) {
  Judged judged;
  CorridorInput& input = judged.input;
  input.dt_s = to_seconds(step);
  const double earth = wgs84::kEarthRate_radps * std::sin(options_.latitude_rad);
  input.turn_rate_rad_s = sample.turn_rate_rad_s - earth;
  input.speed_m_s = sample.speed_m_s;
  input.speed_before_m_s = speed_m_s_;
  input.extra_turn_rad = options_.turn_error * std::abs(input.turn_rate_rad_s) * input.dt_s;
  judged.saturated = std::abs(sample.turn_rate_rad_s) >= 0.999 * options_.gyro_range_rad_s;
  // Beyond its range the gyro tells a least turn, not which.
  if (judged.saturated) input.extra_turn_rad = 0.5 * options_.gyro_range_rad_s * input.dt_s;
  judge_wheels(sample, step, judged);
  standing_ = sample.speed_m_s == 0.0 ? standing_ + step : Duration::zero();
  input.at_rest = standing_ >= options_.rest_after && options_.rest_calibrates;
  speed_m_s_ = input.speed_m_s;
  return judged;
}

}  // namespace wayfare::corridor
