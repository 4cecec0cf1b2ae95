#pragma once

#include <Eigen/Core>

#include <wayfare/pedestrian/pedestrian_parameters.hpp>

namespace wayfare {

/// What is unknown of where a walk has led. Errors of each step add up as a walk of their own;
/// those of all steps stretch and turn the whole way about its start.
class WalkCovariance {
 public:
  explicit WalkCovariance(const PedestrianParameters& p)
      : length2_(square(p.length_sigma)),
        scale2_(square(p.length_scale_sigma)),
        direction2_(square(p.direction_sigma)),
        offset2_(square(p.direction_offset_sigma)) {}

  /// After a step of `length` along a unit vector that led `from_start`; x, y and heading.
  [[nodiscard]] Eigen::Matrix3d step(double length, const Eigen::Vector2d& along,
                                     const Eigen::Vector2d& from_start, double heading_variance) {
    const Eigen::Vector2d across(-along.y(), along.x());
    walk_ += square(length) *
             (length2_ * along * along.transpose() + direction2_ * across * across.transpose());
    const Eigen::Vector2d sideways(-from_start.y(), from_start.x());
    const double common = offset2_ + heading_variance;
    Eigen::Matrix3d p;
    p.topLeftCorner<2, 2>() = walk_ + scale2_ * from_start * from_start.transpose() +
                              common * sideways * sideways.transpose();
    p.topRightCorner<2, 1>() = common * sideways;
    p.bottomLeftCorner<1, 2>() = common * sideways.transpose();
    p(2, 2) = common + direction2_;
    return p;
  }

 private:
  static double square(double x) { return x * x; }

  double length2_, scale2_, direction2_, offset2_;
  Eigen::Matrix2d walk_ = Eigen::Matrix2d::Zero();
};

}  // namespace wayfare
