#pragma once

// Poses with covariances along a drive against the truth: normalised squared errors (NEES).

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include <Eigen/Core>

#include <wayfare/eval/consistency.hpp>
#include <wayfare/sensors/trajectory.hpp>

namespace wayfare::eval {

/// Of the poses of one drive, relative to its first. Errors within a drive are correlated: its mean
/// NEES is one sample for `IndependentMean`.
class PoseConsistency {
 public:
  /// `truth`: in order of time; interpolated.
  explicit PoseConsistency(Trajectory truth) : truth_(std::move(truth)) {}

  /// A pose and the covariance of it relative to the first pose given, right perturbations
  /// (x, y, heading), m and rad. The first one's covariance is not used. False at times without
  /// truth, for which nothing is added.
  bool add(LogTime time, const SE2d& pose, const Eigen::Matrix3d& covariance) {
    const auto truth = pose_at(truth_, time);
    if (!truth) return false;
    if (!start_) {
      start_ = {pose, *truth};
      return true;
    }
    const Eigen::Vector3d error =
        (start_->truth.inverse() * *truth).minus(start_->pose.inverse() * pose);
    const double nees = normalised_squared(error, covariance);
    ++count_;
    sum_ += nees;
    largest_ = std::max(largest_, nees);
    squared_errors_ += error.cwiseAbs2();
    variances_ += covariance.diagonal();
    return true;
  }

  /// Number of poses after the first.
  [[nodiscard]] std::size_t count() const { return count_; }
  /// 3 in the mean of many drives for a consistent estimator; NaN without poses, or with a
  /// covariance that is not positive definite.
  [[nodiscard]] double mean_nees() const { return sum_ / static_cast<double>(count_); }
  /// Of single poses, of those with a positive definite covariance; 0 without any.
  [[nodiscard]] double largest_nees() const { return largest_; }
  /// Root mean squares of the errors, m and rad.
  [[nodiscard]] double error_m() const { return root_mean(squared_errors_.head<2>().sum()); }
  [[nodiscard]] double error_rad() const { return root_mean(squared_errors_[2]); }  ///< of headings
  /// Root mean squares by the covariances, m and rad.
  [[nodiscard]] double sigma_m() const { return root_mean(variances_.head<2>().sum()); }
  [[nodiscard]] double sigma_rad() const { return root_mean(variances_[2]); }  ///< of headings

 private:
  struct Start {
    SE2d pose, truth;
  };
  [[nodiscard]] double root_mean(double sum) const {
    return std::sqrt(sum / static_cast<double>(count_));
  }

  Trajectory truth_;
  std::optional<Start> start_;
  std::size_t count_ = 0;
  double sum_ = 0.0, largest_ = 0.0;
  Eigen::Vector3d squared_errors_ = Eigen::Vector3d::Zero(), variances_ = Eigen::Vector3d::Zero();
};

}  // namespace wayfare::eval
