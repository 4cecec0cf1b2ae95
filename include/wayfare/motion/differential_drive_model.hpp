#pragma once

// How far a robot on two driven wheels got, as a Gaussian on SE(2): from its wheels alone, and from
// its wheels' forward way and a gyro's turn (Zhang 2020, equations 5.2 and 5.3).
//
// Both return the increment T_before_after with its covariance in the axes of where the robot is
// afterwards: right perturbation, (x, y, θ) in m, m, rad. The motion between two samples is a
// circular arc, the exponential of a constant twist, which has no singularity where the robot goes
// straight. The covariance is that of the increment alone; compose() of core/gaussian.hpp carries a
// pose's own along.

#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <wayfare/core/gaussian.hpp>
#include <wayfare/core/se2.hpp>

namespace wayfare {

/// What neither wheels nor gyro see. With all of them zero the covariances are singular: such a
/// robot cannot leave its arc.
struct GroundSlip {
  /// Standard deviation of a sideways slide after one metre, growing with the root of the distance.
  double side_m_per_sqrt_m = 0.002;
  /// Of a turn nobody measured, after one radian of turning, growing with the root of the angle.
  double turn_rad_per_sqrt_rad = 0.01;
  /// Of an increment however small, m and rad: keeps a robot at rest from being certain for ever.
  double floor_m = 1e-5;
  double floor_rad = 1e-5;

  /// Variances over a twist (x, y, θ).
  [[nodiscard]] Eigen::Matrix3d covariance(const Eigen::Vector3d& twist) const {
    const double along = std::abs(twist.x()), turn = std::abs(twist.z());
    const double floor = floor_m * floor_m;
    return Eigen::Vector3d(
               floor, floor + side_m_per_sqrt_m * side_m_per_sqrt_m * along,
               floor_rad * floor_rad + turn_rad_per_sqrt_rad * turn_rad_per_sqrt_rad * turn)
        .asDiagonal();
  }
};

/// An increment and its derivative by the two inputs of the model, in the axes of its end.
struct InputJacobian {
  SE2d increment;
  Eigen::Matrix<double, 3, 2> by_inputs;
};

/// From the way each wheel rolled, forward positive.
struct DifferentialDriveModel {
  double wheel_base_m = 0.4;
  /// Standard deviation of each wheel's way after one metre, growing with the root of the distance.
  double slip_m_per_sqrt_m = 0.004;
  /// Relative uncertainty of each wheel's radius: grows with the distance itself.
  double scale = 0.0;
  GroundSlip ground{};

  /// Twist: the mean of the two wheels along, (right − left) / wheel base about.
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
  [[nodiscard]] Gaussian<SE2d> operator()(double left_m, double right_m) const;

 private:
  [[nodiscard]] double wheel_variance(double way_m) const {
    return slip_m_per_sqrt_m * slip_m_per_sqrt_m * std::abs(way_m) + scale * scale * way_m * way_m;
  }
};

/// From the way along (the mean of the wheels', say) and a gyro's mean rate, counter-clockwise
/// positive.
struct GyroMotion {
  /// Standard deviation of the way along after one metre, growing with the root of the distance.
  double along_m_per_sqrt_m = 0.003;
  /// Relative uncertainty of the way: grows with the distance itself.
  double scale = 0.0;
  /// Standard deviation of the angle after one second, growing with the root of time.
  double angle_random_walk_rad_per_sqrt_s = 0.001;
  /// Standard deviation of the bias left in the rate: grows with time itself.
  double bias_rad_s = 0.0005;
  GroundSlip ground{};

  [[nodiscard]] Eigen::Vector3d twist(double along_m, double turn_rate_rad_s, double dt_s) const {
    return {along_m, 0.0, turn_rate_rad_s * dt_s};
  }
  /// Derivatives by (way along, angle turned).
  [[nodiscard]] InputJacobian linearised(double along_m, double turn_rate_rad_s,
                                         double dt_s) const {
    const Eigen::Vector3d tau = twist(along_m, turn_rate_rad_s, dt_s);
    Eigen::Matrix<double, 3, 2> by_inputs;
    by_inputs << 1.0, 0.0, 0.0, 0.0, 0.0, 1.0;
    return {SE2d::exp(tau), SE2d::right_jacobian(tau) * by_inputs};
  }
  /// Variances of (way along, angle turned).
  [[nodiscard]] Eigen::Vector2d input_variances(double along_m, double dt_s) const {
    const double walk = angle_random_walk_rad_per_sqrt_s, bias = bias_rad_s * dt_s;
    return {along_m_per_sqrt_m * along_m_per_sqrt_m * std::abs(along_m) +
                scale * scale * along_m * along_m,
            walk * walk * std::abs(dt_s) + bias * bias};
  }
  [[nodiscard]] Gaussian<SE2d> operator()(double along_m, double turn_rate_rad_s,
                                          double dt_s) const;
};

namespace detail {
inline Gaussian<SE2d> increment_of(const InputJacobian& j, const Eigen::Vector2d& variances,
                                   const Eigen::Matrix3d& ground) {
  const Eigen::Matrix3d covariance =
      j.by_inputs * variances.asDiagonal() * j.by_inputs.transpose() + ground;
  return {j.increment, Eigen::Matrix3d(0.5 * (covariance + covariance.transpose()))};
}
}  // namespace detail

inline Gaussian<SE2d> DifferentialDriveModel::operator()(double left_m, double right_m) const {
  return detail::increment_of(linearised(left_m, right_m), input_variances(left_m, right_m),
                              ground.covariance(twist(left_m, right_m)));
}

inline Gaussian<SE2d> GyroMotion::operator()(double along_m, double turn_rate_rad_s,
                                             double dt_s) const {
  return detail::increment_of(linearised(along_m, turn_rate_rad_s, dt_s),
                              input_variances(along_m, dt_s),
                              ground.covariance(twist(along_m, turn_rate_rad_s, dt_s)));
}

/// Both as one, by the product of their densities (Zhang 2020, equation 5.4), the heading's
/// difference wrapped. It takes the two for independent: where both have their way along from the
/// same wheels, that part of the covariance comes out at half its due, and the caller who minds
/// gives GyroMotion::along_m_per_sqrt_m a value √2 times larger, and DifferentialDriveModel's slip
/// likewise. An Error where neither covariance is definite in some direction.
[[nodiscard]] inline Result<Gaussian<SE2d>> fuse(const Gaussian<SE2d>& wheels,
                                                 const Gaussian<SE2d>& gyro) {
  return product(wheels, gyro);
}

/// Draws of one Gaussian, factorised once: what moves a set of particles. The covariance may be
/// singular.
class MotionSampler {
 public:
  explicit MotionSampler(const Gaussian<SE2d>& motion) : mean_(motion.mean) {
    const Eigen::LDLT<Eigen::Matrix3d> ldlt(motion.covariance);
    const Eigen::Vector3d root = ldlt.vectorD().cwiseMax(0.0).cwiseSqrt();
    const Eigen::Matrix3d lower = ldlt.matrixL();
    root_ = ldlt.transpositionsP().transpose() * Eigen::Matrix3d(lower * root.asDiagonal());
  }

  [[nodiscard]] SE2d operator()(Rng& rng) const {
    Eigen::Vector3d white;
    for (double& w : white) w = rng.normal();
    return mean_.plus(root_ * white);
  }

 private:
  SE2d mean_;
  Eigen::Matrix3d root_;  ///< root · rootᵀ is the covariance
};

}  // namespace wayfare
