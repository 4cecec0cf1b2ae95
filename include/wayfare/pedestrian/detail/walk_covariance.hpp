#pragma once

#include <Eigen/Core>

#include <wayfare/pedestrian/parameters.hpp>

namespace wayfare {

/// Covariance of a dead-reckoned pose. Independent errors of the steps accumulate as a random walk;
/// common ones scale and rotate the whole path about its start.
class WalkCovariance {
 public:
  explicit WalkCovariance(const PedestrianParameters& p)
      : length2_(square(p.length_sigma)),
        scale2_(square(p.length_scale_sigma)),
        direction2_(square(p.direction_sigma)),
        offset2_(square(p.direction_offset_sigma)) {}

  /// Covariance of x, y and heading after a step of `length` along a unit vector, at `from_start`.
  [[nodiscard]] Eigen::Matrix3d step(double length, const Eigen::Vector2d& along,
                                     const Eigen::Vector2d& from_start, double heading_variance) {
    const Eigen::Vector2d across(-along.y(), along.x());
    independent_ += square(length) * (length2_ * along * along.transpose() +
                                      direction2_ * across * across.transpose());
    const Eigen::Vector2d sideways(-from_start.y(), from_start.x());
    const double common = offset2_ + heading_variance;
    Eigen::Matrix3d p;
    p.topLeftCorner<2, 2>() = independent_ + scale2_ * from_start * from_start.transpose() +
                              common * sideways * sideways.transpose();
    p.topRightCorner<2, 1>() = common * sideways;
    p.bottomLeftCorner<1, 2>() = common * sideways.transpose();
    p(2, 2) = common + direction2_;
    return p;
  }

 private:
  static double square(double x) { return x * x; }

  double length2_, scale2_, direction2_, offset2_;
  Eigen::Matrix2d independent_ = Eigen::Matrix2d::Zero();
};

}  // namespace wayfare
