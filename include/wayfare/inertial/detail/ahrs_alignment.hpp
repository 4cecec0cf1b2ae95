#pragma once

#include <cmath>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <wayfare/inertial/ahrs_parameters.hpp>
#include <wayfare/inertial/detail/ahrs_filter.hpp>

namespace wayfare::align {

/// Resets bias and delay to their initial values.
template <class T>
void forget_bias(AhrsFilter<T>& filter, const AhrsParameters& p) {
  for (int i = 0; i < 3; ++i)
    filter.covariance().decouple(AhrsFilter<T>::kBias + i, T(p.bias_sigma * p.bias_sigma));
  const double delay = p.use_magnetometer ? p.magnetometer_delay_sigma_s : 0.0;
  filter.covariance().decouple(AhrsFilter<T>::kDelay, T(delay * delay));
  filter.set_bias(AhrsFilter<T>::Vector::Zero());
  filter.set_delay(T(p.magnetometer_delay_s));
}

template <class T>
void forget_velocity(AhrsFilter<T>& filter, T variance) {
  filter.set_velocity(Eigen::Matrix<T, 2, 1>::Zero());
  filter.covariance().decouple(AhrsFilter<T>::kVelocity, variance);
  filter.covariance().decouple(AhrsFilter<T>::kVelocity + 1, variance);
}

/// Applies the smallest rotation that makes `force` point up. The tilt then has standard deviation
/// `sigma`; the heading variance grows with the rotation angle.
template <class T>
void level(AhrsFilter<T>& filter, const Eigen::Matrix<T, 3, 1>& force, T sigma) {
  using Vector = Eigen::Matrix<T, 3, 1>;
  const auto rotation = SO3<T>::between(filter.rotation() * force, Vector::UnitZ());
  filter.set_attitude(rotation * filter.q_enu_body());
  const T angle = rotation.log().norm();
  auto& p = filter.covariance();
  const T heading = p(2, 2) + T(0.25) * angle * angle;
  p.decouple(0, sigma * sigma);
  p.decouple(1, sigma * sigma);
  p.decouple(2, heading);
}

/// Rotates the attitude about the vertical by `angle`, counter-clockwise; the heading then has
/// standard deviation `sigma`.
template <class T>
void turn_heading(AhrsFilter<T>& filter, T angle, T sigma) {
  filter.set_attitude(SO3<T>::exp({T(0), T(0), angle}) * filter.q_enu_body());
  filter.set_velocity(Eigen::Rotation2D<T>(angle) * filter.velocity());
  filter.covariance().decouple(2, sigma * sigma);
}

}  // namespace wayfare::align
