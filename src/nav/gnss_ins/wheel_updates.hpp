#pragma once

// Updates by the speed of the wheels, which may slip.

#include <concepts>
#include <optional>

#include <wayfare/inertial/ins_measurements.hpp>
#include <wayfare/nav/gnss_ins.hpp>

#include "nav/gnss_ins/receiver_clocks.hpp"

namespace wayfare::nav {

/// Initial values and variances of Odometer.
template <class State>
void start_odometer(const OdometerOptions& o, State& x, SquareOf<State>& p) {
  constexpr int k = State::template index<ins::Odometer<double>>();
  x.odometer.template tail<3>() = o.lever_arm_m;
  const double direction = o.direction_sigma_rad * o.direction_sigma_rad;
  const double lever = o.lever_arm_sigma_m * o.lever_arm_sigma_m;
  p.diagonal().template segment<6>(k) << o.scale_sigma * o.scale_sigma, direction, direction, lever,
      lever, lever;
}

/// A further block with its noise.
template <class Block>
[[nodiscard]] Block further_block(const GnssInsOptions& options) {
  if constexpr (std::same_as<Block, ins::Odometer<double>>) {
    typename Block::Value walk = Block::Value::Zero();
    if (options.odometer) walk[0] = options.odometer->scale_walk_per_sqrt_s;
    return Block(walk);
  } else {
    return {};
  }
}

/// Wheels of a filter with Odometer.
template <class Filter>
class WheelUpdates {
 public:
  WheelUpdates(const GnssInsOptions& options, const OdometerOptions& odometer)
      : options_(odometer),
        reopen_s_(options.gate_reopen_s),
        outage_sigma_mps_(options.non_holonomic_sigma_mps),
        across_gate_sigma_(options.gate_sigma),
        body_unit_(options.q_body_imu.matrix()) {}

  /// Of the axle along `axis`: 0 forward, 1 to the right, 2 down.
  [[nodiscard]] AxleVelocityModel<double, kOffsets> model(const Filter& filter, int axis,
                                                          double speed_mps,
                                                          double sigma_mps) const {
    return {axis, speed_mps, sigma_mps * sigma_mps, body_unit_, filter.gyro_radps()};
  }

  /// Updates by a reading at the filter's time. True where the wheels disagreed for so long that
  /// the uncertainty was inflated.
  template <class Record>
  bool update(Filter& filter, const WheelSpeed& wheels, const Record& record) {
    const auto u = filter.ekf().update(model(filter, 0, wheels.speed_mps, options_.speed_sigma_mps),
                                       options_.gate_sigma);
    record(u);
    if (u.accepted) {
      slips_since_.reset();
      return false;
    }
    if (!slips_since_) slips_since_ = wheels.time;
    if (to_seconds(wheels.time - *slips_since_) < reopen_s_) return false;
    constexpr int kOdometer = Filter::State::template index<ins::Odometer<double>>();
    inflate(filter, ins_state::kVelocity, 3);
    inflate(filter, kOdometer, 1);
    slips_since_ = wheels.time;
    return true;
  }

  /// The axle does not move across the direction of travel.
  template <class Record>
  void update_across(Filter& filter, bool with_satellites, const Record& record) const {
    const double sigma_mps = with_satellites ? options_.cross_sigma_mps : outage_sigma_mps_;
    if (sigma_mps <= 0.0 || filter.state().velocity_mps.norm() < 0.5) return;
    for (int axis = 1; axis < 3; ++axis)
      record(filter.ekf().update(model(filter, axis, 0.0, sigma_mps), across_gate_sigma_));
  }

 private:
  OdometerOptions options_;
  double reopen_s_, outage_sigma_mps_, across_gate_sigma_;
  Eigen::Matrix3d body_unit_;
  std::optional<LogTime> slips_since_;
};

}  // namespace wayfare::nav
