#pragma once

// Updates by the speed of the wheels, which may slip.

#include <algorithm>
#include <optional>

#include <wayfare/nav/gnss_ins.hpp>

#include "nav/gnss_ins/receiver_clocks.hpp"

namespace wayfare::nav {

/// Wheels of a filter with Odometer.
template <class Filter>
class WheelUpdates {
 public:
  explicit WheelUpdates(const GnssInsOptions& options)
      : options_(options.odometer.value_or(OdometerOptions{})),
        reopen_s_(options.gate_reopen_s),
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
    filter.ekf().scale_sigma(ins_state::kVelocity, 3, 1.5);
    filter.ekf().scale_sigma(kOdometer, 1, 1.5);
    slips_since_ = wheels.time;
    return true;
  }

  /// σ of the velocity across, with satellites; zero: none.
  [[nodiscard]] double cross_sigma_mps() const { return options_.cross_sigma_mps; }

 private:
  OdometerOptions options_;
  double reopen_s_;
  Eigen::Matrix3d body_unit_;
  std::optional<LogTime> slips_since_;
};

}  // namespace wayfare::nav
