#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Core>

#include <wayfare/core/se2.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/motion/motion_noise.hpp>

namespace wayfare {

/// Of a pose of which nothing is known, m² and rad².
inline constexpr double kUnknownVariance = 1e12;
[[nodiscard]] inline Eigen::Matrix3d unknown_covariance() {
  return kUnknownVariance * Eigen::Matrix3d::Identity();
}

/// A motion with its standard deviation, in the frame at its end.
struct Motion {
  SE2d increment;
  Eigen::Vector3d sigma = Eigen::Vector3d::Zero();  ///< m, m, rad
  bool measured = false;                            ///< by odometry, not predicted by a velocity

  [[nodiscard]] Eigen::Matrix3d covariance() const { return sigma.cwiseAbs2().asDiagonal(); }
  /// Of the motion since an earlier pose, given its covariance before this one.
  [[nodiscard]] Eigen::Matrix3d accumulated(const Eigen::Matrix3d& before) const {
    const Eigen::Matrix3d turn = increment.inverse().adjoint();
    const Eigen::Matrix3d sum = turn * before * turn.transpose() + covariance();
    // Leaps of odometry would make products overflow.
    return sum.diagonal().maxCoeff() < kUnknownVariance ? sum : unknown_covariance();
  }
};

[[nodiscard]] inline Eigen::Matrix3d information_of(const Eigen::Vector3d& sigma) {
  return sigma.cwiseAbs2().cwiseInverse().asDiagonal();
}

/// A motion without noise has no information matrix: at least 1 µm and 1 µrad. Nothing where one of
/// them is NaN: such a motion is not known.
[[nodiscard]] inline std::optional<Eigen::Vector3d> at_least_rounding(
    const Eigen::Vector3d& sigma) {
  constexpr double kLeast = 1e-6;
  if (sigma.hasNaN()) return std::nullopt;
  return sigma.cwiseMax(kLeast);
}

/// Whether a motion reaches this travel or heading change.
[[nodiscard]] inline bool reaches(const SE2d& motion, double travel_m, Angle turn) {
  return motion.translation().norm() >= travel_m ||
         std::abs(motion.heading().radians()) >= turn.radians();
}

/// Odometry that leaps farther between two scans counts as missing: the information of an edge of
/// such uncertainty is zero to rounding, and the graph could not be optimised.
inline constexpr double kLongestMotion_m = 1e4;

/// Over a shorter interval no velocity is measured: errors of the poses would be divided by it.
inline constexpr double kShortestInterval_s = 1e-3;

/// A velocity is not extrapolated longer.
inline constexpr double kVelocityHolds_s = 0.5;

/// Predicts the next scan's pose from odometry, or at constant velocity.
class MotionModel {
 public:
  MotionModel(const MotionNoise& odometry, const MotionNoise& constant_velocity)
      : odometry_noise_(odometry), velocity_noise_(constant_velocity) {}

  /// From the last scan to `time`: the odometry increment if both ends and its noise are known and
  /// it is no leap, else at the velocity between the last two scans. Where the noise of that is NaN
  /// it is 1 m and 1 rad. The velocity holds for `longest_s`: not through a gap in the log.
  [[nodiscard]] Motion predict(LogTime time, const std::optional<SE2d>& odometry,
                               double longest_s = kVelocityHolds_s) const {
    if (!last_) return {};
    if (odometry && last_->odometry) {
      const SE2d increment = last_->odometry->inverse() * *odometry;
      const auto sigma = at_least_rounding(sigma_of(increment, odometry_noise_));
      if (sigma && increment.translation().norm() < kLongestMotion_m)
        return {increment, *sigma, true};
    }
    const SE2d increment = SE2d::exp(velocity_ * interval_s(time, longest_s));
    const auto sigma = at_least_rounding(sigma_of(increment, velocity_noise_));
    return {increment, sigma.value_or(Eigen::Vector3d::Ones())};
  }

  /// Adds a scan's estimated pose. Timestamp jitter makes short intervals look fast: an interval
  /// much shorter than usual is combined with the next one.
  void update(LogTime time, const SE2d& pose, const std::optional<SE2d>& odometry) {
    if (last_) {
      constexpr double kGain = 0.1;
      const double step = interval_s(time);
      mean_interval_s_ =
          mean_interval_s_ > 0.0 ? mean_interval_s_ + kGain * (step - mean_interval_s_) : step;
      const double dt = to_seconds(time - velocity_from_.time);
      if (dt >= kShortestInterval_s && dt >= 0.5 * mean_interval_s_) {
        velocity_ = pose.minus(velocity_from_.pose) / dt;
        velocity_from_ = {time, pose};
      }
    } else {
      velocity_from_ = {time, pose};
    }
    last_ = {time, pose, odometry};
  }

  /// Replaces the last scan's pose, without a change of velocity.
  void correct(const SE2d& pose) {
    if (!last_) return;
    velocity_from_.pose = pose * last_->pose.inverse() * velocity_from_.pose;
    last_->pose = pose;
  }

 private:
  friend struct MotionState;  // saves and restores it

  struct Placed {
    LogTime time;
    SE2d pose;
    std::optional<SE2d> odometry;
  };
  struct Start {
    LogTime time;
    SE2d pose;
  };

  /// Since the last scan.
  [[nodiscard]] double interval_s(LogTime time, double longest_s = kVelocityHolds_s) const {
    return std::min(to_seconds(time - last_->time), longest_s);
  }

  MotionNoise odometry_noise_, velocity_noise_;
  std::optional<Placed> last_;
  Start velocity_from_;                                 // start of the latest velocity measurement
  double mean_interval_s_ = 0.0;                        // mean interval between scans
  Eigen::Vector3d velocity_ = Eigen::Vector3d::Zero();  // body frame, per second
};

/// Whether odometry differs from the constant-velocity prediction by more than the latter's error.
/// (The error of odometry itself grows with the size of a jump in it.)
[[nodiscard]] inline bool contradicts(const Motion& odometry, const Motion& by_velocity,
                                      double sigmas) {
  const Eigen::Vector3d d = odometry.increment.minus(by_velocity.increment);
  return (d.cwiseAbs().array() > sigmas * by_velocity.sigma.array()).any();
}

/// Whether it differs so much that even a fair match at the odometry pose must be verified.
[[nodiscard]] inline bool jumps(const Motion& odometry, const Motion& by_velocity) {
  constexpr double kLeap_m = 1.0;
  return (odometry.increment.translation() - by_velocity.increment.translation()).norm() > kLeap_m;
}

}  // namespace wayfare
