#pragma once

#include <optional>

#include <wayfare/nav/gnss_ins.hpp>

#include "nav/gnss_ins/zero_velocity_detector.hpp"

namespace wayfare::nav {

/// Antenna position and velocity by least squares on one epoch.
struct RangeSolution {
  Eigen::Vector3d position_ecef_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_ecef_mps = Eigen::Vector3d::Zero();
  bool has_velocity = false;
  double position_sigma_m = 0.0;  ///< the worst axis
};

/// None for too few or inconsistent ranges.
[[nodiscard]] std::optional<RangeSolution> solve_ranges(const RangeEpoch& epoch);

/// Collects the initial state: position, heading from velocity, tilt from inertial readings.
class Starter {
 public:
  explicit Starter(const GnssInsOptions& options) : options_(options) {}

  void add(const ImuSample& sample);
  [[nodiscard]] std::optional<GnssInsStart> add(const RangeEpoch& epoch);
  [[nodiscard]] std::optional<GnssInsStart> add(const GnssFix& fix);

 private:
  struct VelocityFix {
    LogTime time;
    Eigen::Vector3d velocity_ned_mps;
  };
  [[nodiscard]] std::optional<GnssInsStart> try_start(LogTime time, const Geodetic& antenna,
                                                      const Eigen::Vector3d& velocity_ned_mps,
                                                      double position_sigma_m);

  GnssInsOptions options_;
  RecentReadings recent_;
  std::optional<ImuSample> last_;
  std::optional<VelocityFix> before_;
  bool standing_ = false;  ///< by the latest GNSS velocity
  Eigen::Vector3d standing_rate_sum_ = Eigen::Vector3d::Zero();
  int standing_count_ = 0;
  double standing_s_ = 0.0;
};

}  // namespace wayfare::nav
