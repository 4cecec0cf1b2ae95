#pragma once

#include <algorithm>
#include <cmath>

#include <wayfare/core/geodesy.hpp>
#include <wayfare/nav/corridor_ins.hpp>

namespace wayfare::corridor {

/// Finite, and not far beyond any vehicle, so that the covariance cannot overflow.
[[nodiscard]] inline bool plausible(const MotionSample& s) {
  constexpr double kFastest = 1e3;
  return std::abs(s.turn_rate_rad_s) < kFastest && std::abs(s.speed_m_s) < kFastest;
}

/// Zero where rounding has left less.
[[nodiscard]] inline double sigma_of(double variance) { return std::sqrt(std::max(variance, 0.0)); }

/// Plausibility checks of gyro and wheels over consecutive samples.
class MotionWatch {
 public:
  explicit MotionWatch(const CorridorInsOptions& options) : options_(options) {}

  struct Checked {
    CorridorInput input;
    bool saturated = false, slipping = false, slip_began = false;
  };
  /// The step from the previous sample to this one; times are in order.
  [[nodiscard]] Checked check(const MotionSample& sample, Duration step) {
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

 private:
  void check_wheels(const MotionSample& sample, Duration step, Checked& checked) {
    const double dt = to_seconds(step);
    // Braking during wheel spin is not measured: lower speeds are accepted sooner after longer
    // spin.
    const double gain = sample.speed_m_s - speed_m_s_;
    const double slipping_s = gain < 0.0 ? to_seconds(slipping_) : 0.0;
    const bool jumps =
        std::abs(gain) > options_.greatest_acceleration_m_s2 * (dt + 0.2 * slipping_s);
    checked.slipping = jumps && slipping_ < options_.longest_slip;
    checked.slip_began = checked.slipping && slipping_ == Duration::zero();
    slipping_ = checked.slipping ? slipping_ + step : Duration::zero();
    if (!checked.slipping) return;
    checked.input.speed_m_s = speed_m_s_;
    checked.input.extra_distance_m = (0.1 + 0.5 * std::abs(speed_m_s_)) * std::sqrt(dt);
  }

  CorridorInsOptions options_;
  double speed_m_s_ = 0.0;  ///< last accepted
  Duration standing_{0}, slipping_{0};
};

}  // namespace wayfare::corridor
