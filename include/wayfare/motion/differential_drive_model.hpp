#pragma once

// Motion of a robot with two driven wheels, as a Gaussian on SE(2): from its wheels alone, and from
// the forward distance of its wheels and a gyro's angle (Zhang 2020, equations 5.2 and 5.3).
//
// Both return the increment T_before_after with its covariance in the axes of the final pose: right
// perturbation, (x, y, θ) in m, m, rad. The motion between two samples is a circular arc, the
// exponential of a constant twist, which is regular for straight motion. The covariance is that of
// the increment alone; compose() of core/gaussian.hpp propagates that of a pose.

#include <cmath>

#include <Eigen/Core>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/gaussian.hpp>
#include <wayfare/core/gaussian_sampler.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/motion/motion_noise.hpp>

namespace wayfare {

/// Motion that neither wheels nor gyro measure. If all are zero, the covariances are singular: the
/// robot cannot leave its arc.
struct GroundSlip {
  /// Standard deviation of a sideways slide after one metre, growing with the root of the distance.
  double side_m_per_sqrt_m = 0.002;
  /// Of an unmeasured rotation after one radian, growing with the root of the angle.
  double turn_rad_per_sqrt_rad = 0.01;
  /// Of any increment along and across, m: keeps the variance of a robot at rest from staying zero.
  double floor_m = 1e-5;
  double floor_rad = 1e-5;  ///< rad, of the rotation of any increment

  /// Covariance of a twist (x, y, θ).
  [[nodiscard]] Eigen::Matrix3d covariance(const Eigen::Vector3d& twist) const {
    const double along = std::abs(twist.x()), turn = std::abs(twist.z());
    const double floor = floor_m * floor_m;
    return Eigen::Vector3d(
               floor, floor + side_m_per_sqrt_m * side_m_per_sqrt_m * along,
               floor_rad * floor_rad + turn_rad_per_sqrt_rad * turn_rad_per_sqrt_rad * turn)
        .asDiagonal();
  }
};

/// An increment and its derivative by the two inputs of the model, in the axes of the final pose.
struct InputJacobian {
  SE2d increment;                         ///< T_before_after
  Eigen::Matrix<double, 3, 2> by_inputs;  ///< rows (x, y, θ): m and rad per unit of an input

  /// The increment of inputs with these variances on a ground of this covariance.
  [[nodiscard]] Gaussian<SE2d> with_noise(const Eigen::Vector2d& variances,
                                          const Eigen::Matrix3d& ground) const {
    const Eigen::Matrix3d covariance =
        by_inputs * variances.asDiagonal() * by_inputs.transpose() + ground;
    return {increment, Eigen::Matrix3d(0.5 * (covariance + covariance.transpose()))};
  }
};

/// From the distance rolled by each wheel, forward positive.
struct DifferentialDriveModel {
  double wheel_base_m = 0.4;  ///< m, distance of the wheels' contact points
  /// Standard deviation of each wheel's distance after one metre, growing with its root.
  double slip_m_per_sqrt_m = 0.004;
  /// Relative uncertainty of each wheel's radius: its effect is proportional to the distance.
  double scale = 0.0;
  GroundSlip ground{};  ///< added to the covariance of the wheels

  /// Twist: mean of the two wheels along x, (right − left) / wheel base about z.
  [[nodiscard]] Eigen::Vector3d twist(double left_m, double right_m) const {
    return {0.5 * (left_m + right_m), 0.0, (right_m - left_m) / wheel_base_m};
  }
  /// Derivatives by (left, right).
  [[nodiscard]] InputJacobian linearised(double left_m, double right_m) const {
    const Eigen::Vector3d tau = twist(left_m, right_m);
    Eigen::Matrix<double, 3, 2> by_wheels;
    by_wheels << 0.5, 0.5, 0.0, 0.0, -1.0 / wheel_base_m, 1.0 / wheel_base_m;
    return {SE2d::exp(tau), SE2d::right_jacobian(tau) * by_wheels};
  }
  /// Variances of (left, right).
  [[nodiscard]] Eigen::Vector2d input_variances(double left_m, double right_m) const {
    return {wheel_variance(left_m), wheel_variance(right_m)};
  }
  /// Increment of the distances rolled, m, with its covariance: Σ = J Q Jᵀ + ground.
  [[nodiscard]] Gaussian<SE2d> operator()(double left_m, double right_m) const {
    return linearised(left_m, right_m)
        .with_noise(input_variances(left_m, right_m), ground.covariance(twist(left_m, right_m)));
  }

 private:
  [[nodiscard]] double wheel_variance(double distance_m) const {
    return slip_m_per_sqrt_m * slip_m_per_sqrt_m * std::abs(distance_m) +
           scale * scale * distance_m * distance_m;
  }
};

/// From the forward distance (e.g. the mean of the wheels) and a gyro's mean rate,
/// counter-clockwise positive.
struct GyroMotion {
  /// Standard deviation of the forward distance after one metre, growing with its root.
  double along_m_per_sqrt_m = 0.003;
  /// Relative uncertainty of the distance: its effect is proportional to the distance.
  double scale = 0.0;
  /// Standard deviation of the angle after one second, growing with the root of time.
  double angle_random_walk_rad_per_sqrt_s = 0.001;
  /// Standard deviation of the residual bias of the rate: its effect is proportional to time.
  double bias_rad_s = 0.0005;
  GroundSlip ground{};  ///< added to the covariance of distance and gyro

  /// Twist: the distance along x, rate times interval about z.
  [[nodiscard]] Eigen::Vector3d twist(double along_m, double turn_rate_rad_s, double dt_s) const {
    return {along_m, 0.0, turn_rate_rad_s * dt_s};
  }
  /// Derivatives by (forward distance, rotation angle).
  [[nodiscard]] InputJacobian linearised(double along_m, double turn_rate_rad_s,
                                         double dt_s) const {
    const Eigen::Vector3d tau = twist(along_m, turn_rate_rad_s, dt_s);
    Eigen::Matrix<double, 3, 2> by_inputs;
    by_inputs << 1.0, 0.0, 0.0, 0.0, 0.0, 1.0;
    return {SE2d::exp(tau), SE2d::right_jacobian(tau) * by_inputs};
  }
  /// Variances of (forward distance, rotation angle).
  [[nodiscard]] Eigen::Vector2d input_variances(double along_m, double dt_s) const {
    const double walk = angle_random_walk_rad_per_sqrt_s, bias = bias_rad_s * dt_s;
    return {along_m_per_sqrt_m * along_m_per_sqrt_m * std::abs(along_m) +
                scale * scale * along_m * along_m,
            walk * walk * std::abs(dt_s) + bias * bias};
  }
  /// Increment of the forward distance, mean rate and interval, with its covariance.
  [[nodiscard]] Gaussian<SE2d> operator()(double along_m, double turn_rate_rad_s,
                                          double dt_s) const {
    return linearised(along_m, turn_rate_rad_s, dt_s)
        .with_noise(input_variances(along_m, dt_s),
                    ground.covariance(twist(along_m, turn_rate_rad_s, dt_s)));
  }
};

/// Fuses both by the product of their densities (Zhang 2020, equation 5.4), with the heading
/// difference wrapped. Assumes independence: where both distances come from the same wheels, their
/// variance is half of what it should be; to compensate, increase GyroMotion::along_m_per_sqrt_m
/// and DifferentialDriveModel's slip by √2. An Error where both covariances are singular in the
/// same direction.
template <LieGroup G>
[[nodiscard]] Result<Gaussian<G>> fuse(const Gaussian<G>& wheels, const Gaussian<G>& gyro) {
  return product(wheels, gyro);
}

/// Draws samples of a motion, e.g. to move a set of particles.
using MotionSampler = GaussianSampler<SE2d>;

}  // namespace wayfare
