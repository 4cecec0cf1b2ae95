#pragma once

#include <Eigen/Core>

#include <wayfare/nav/gnss_ins.hpp>
#include <wayfare/nav/ins_filter.hpp>

#include "nav/gnss_ins/ins_view.hpp"
#include "nav/gnss_ins/phase_changes.hpp"
#include "nav/gnss_ins/receiver_clocks.hpp"
#include "nav/gnss_ins/wheel_updates.hpp"

namespace wayfare::nav {

/// The filter at a start, with further blocks of states.
template <class... Further>
[[nodiscard]] InsRangeFilter<Further...> initial_filter(const GnssInsOptions& o,
                                                        const GnssInsStart& start) {
  using Filter = InsRangeFilter<Further...>;
  using State = typename Filter::State;
  using Eigen::Vector3d;
  using namespace ins_state;
  State x;
  x.velocity_mps = start.nav.velocity_ned_mps;
  x.q_nu = start.nav.q_nb * o.q_body_imu;
  typename Filter::Square p = Filter::Square::Zero();
  const auto set = [&p](int first, const Vector3d& sigma) {
    p.diagonal().template segment<3>(first) = sigma.cwiseAbs2();
  };
  set(kPosition, Vector3d::Constant(start.position_sigma_m));
  set(kVelocity, Vector3d::Constant(start.velocity_sigma_mps));
  // Tilt and heading are about north, east and down; the state's error about the unit's axes.
  const Eigen::Matrix3d c = x.q_nu.matrix();
  const Vector3d level(start.level_sigma_rad, start.level_sigma_rad, start.heading_sigma_rad);
  p.template block<3, 3>(kAttitude, kAttitude) = c.transpose() * level.cwiseAbs2().asDiagonal() * c;
  const bool bias_known = start.gyro_bias_sigma_radps > 0.0;
  if (bias_known) x.gyro_bias_radps = start.gyro_bias_radps;
  set(kGyroBias,
      bias_known ? Vector3d::Constant(start.gyro_bias_sigma_radps) : o.imu.gyro_bias_radps.sigma);
  set(kAccelBias, o.imu.accel_bias_mps2.sigma);
  set(kGyroScale, o.imu.gyro_scale.sigma);
  set(kAccelScale, o.imu.accel_scale.sigma);
  p.diagonal().template segment<2 + kOffsets>(kClock).setConstant(1e4);
  if constexpr (kIsAided<State>)
    if (o.odometer) start_odometer(*o.odometer, x, p);
  const Vector3d lever = o.q_body_imu.inverse() * o.antenna_lever_arm_m;
  return {start.nav.position,          0.0, x, p, InsNoise<double>(o.imu, o.clock), lever,
          further_block<Further>(o)...};
}

}  // namespace wayfare::nav
