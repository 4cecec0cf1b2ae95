#pragma once

#include <vector>

#include <Eigen/Core>

#include <wayfare/core/gaussian.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/slam/scan_outcome.hpp>

#include "slam/matched.hpp"

namespace wayfare {

/// Covariances of poses relative to the first scan of a map to which all scans are matched: of the
/// least uncertain scan in the map nearby, and the drift since. Without scans nothing is uncertain.
class MapUncertainty {
 public:
  explicit MapUncertainty(const PathDrift& drift) : drift_(drift) {}

  /// A scan is added to the map at a pose by a match of this covariance.
  void add(const SE2d& pose, const Eigen::Matrix3d& matched) {
    inserted_.push_back({pose, at(pose, lasting_covariance(matched))});
  }

  /// Of a pose that is placed with a covariance in the map nearby.
  [[nodiscard]] Eigen::Matrix3d at(const SE2d& pose, const Eigen::Matrix3d& placed) const {
    constexpr double kNear_m = 2.0;  // with a common view
    if (inserted_.empty()) return placed;
    Eigen::Matrix3d best = from(inserted_.back(), pose);
    for (const Gaussian<SE2d>& scan : inserted_) {
      if (!((scan.mean.translation() - pose.translation()).norm() < kNear_m)) continue;
      const Eigen::Matrix3d covariance = from(scan, pose);
      if (covariance.trace() < best.trace()) best = covariance;
    }
    return best + placed;
  }

 private:
  [[nodiscard]] Eigen::Matrix3d from(const Gaussian<SE2d>& scan, const SE2d& pose) const {
    const SE2d step = scan.mean.inverse() * pose;
    return compose(scan, Gaussian<SE2d>{step, drift_.covariance(step.translation().norm())})
        .covariance;
  }

  PathDrift drift_;
  std::vector<Gaussian<SE2d>> inserted_;
};

}  // namespace wayfare
