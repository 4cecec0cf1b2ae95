#pragma once

// Monte-Carlo test of the navigation filter's consistency: one drive with different errors of the
// unit, the ranges and the start.

#include <array>
#include <cstddef>
#include <functional>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/random.hpp>
#include <wayfare/nav/gnss_ins.hpp>
#include <wayfare/sim/gnss.hpp>
#include <wayfare/sim/vehicle_trajectory.hpp>

namespace wayfare::sim {

/// Sum of squared normalised innovations, rejected ones included.
struct NisSum {
  double sum = 0.0;       ///< of ν²/σ²
  std::size_t count = 0;  ///< number of innovations
};
/// By InnovationRecord::Kind.
using NisByKind = std::array<NisSum, InnovationRecord::kKinds>;

/// Errors of the 23 states at one range epoch (truth minus estimate, in the states' order) and the
/// filter's standard deviations.
struct InsErrorAt {
  using Vector = Eigen::Matrix<double, ins_state::kSize, 1>;          ///< in the order of ins_state
  LogTime time;                                                       ///< of the epoch
  Vector error = Vector::Zero();                                      ///< truth minus estimate
  Vector sigma = Vector::Zero();                                      ///< the filter's
  double nees = std::numeric_limits<double>::quiet_NaN();             ///< all 23 states
  double navigation_nees = std::numeric_limits<double>::quiet_NaN();  ///< the first nine
  NisByKind nis;  ///< of the measurements since the previous entry, this epoch's included
};
using InsErrorSeries = std::vector<InsErrorAt>;  ///< one entry per epoch

/// Sensors, filter and start of the runs.
struct InsMonteCarloOptions {
  ImuParams imu;            ///< simulated unit
  RangeParams ranges;       ///< simulated receiver
  WheelSpeedParams wheels;  ///< simulated, where `filter` has an odometer
  /// Noise parameters, mounting and lever arm are taken from the simulated sensors.
  GnssInsOptions filter;
  /// Standard deviations of the initial state, which is drawn around the truth.
  GnssInsStart start;
  /// Errors of smooth_gnss_ins instead of the filter; without innovations.
  bool smooth = false;
  int threads = 1;  ///< any number gives the same result
};

/// One run: an entry for each range epoch after the first that coincides with a sample of the unit.
[[nodiscard]] InsErrorSeries ins_error_series(const VehicleTrajectory& trajectory,
                                              const Constellation& constellation,
                                              const InsMonteCarloOptions& options, const Rng& rng);

/// `runs` runs, each drawing from its own stream of `rng`.
[[nodiscard]] std::vector<InsErrorSeries> ins_monte_carlo(
    const VehicleTrajectory& trajectory, const Constellation& constellation, std::size_t runs,
    const InsMonteCarloOptions& options, const Rng& rng,
    const std::function<void(double)>& progress = {});

}  // namespace wayfare::sim
