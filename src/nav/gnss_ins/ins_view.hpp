#pragma once

#include <Eigen/Core>

#include <wayfare/core/geodesy.hpp>
#include <wayfare/nav/gnss_ins.hpp>

#include "nav/gnss_ins/receiver_clocks.hpp"

namespace wayfare::nav {

/// Whether a state has the blocks of wheels, and of an earlier antenna position.
template <class State>
inline constexpr bool kIsAided = requires(const State& x) {
  x.odometer;
  x.earlier;
};

/// State and covariance of a filter at one instant, and what they are relative to.
template <class State>
struct InsView {
  LogTime time;
  const LocalTangentPlane& plane;
  double clock_anchor_m;
  const State& x;
  const SquareOf<State>& p;

  [[nodiscard]] NavState nav(const SO3d& q_body_imu) const {
    return {time, plane.geodetic(x.position_m), x.velocity_mps, x.q_nu * q_body_imu.inverse()};
  }

  [[nodiscard]] GnssInsEstimate estimate(const SO3d& q_body_imu) const {
    using namespace ins_state;
    GnssInsEstimate e;
    e.nav = nav(q_body_imu);
    e.gyro_bias_radps = x.gyro_bias_radps;
    e.accel_bias_mps2 = x.accel_bias_mps2;
    e.gyro_scale = x.gyro_scale;
    e.accel_scale = x.accel_scale;
    e.clock_bias_m = clock_anchor_m + x.clock[0];
    e.clock_drift_mps = x.clock[1];
    // The attitude error in body axes: R_body_unit · unit error.
    Eigen::Matrix<double, kSize, kSize> rotation = Eigen::Matrix<double, kSize, kSize>::Identity();
    rotation.block<3, 3>(kAttitude, kAttitude) = q_body_imu.matrix();
    e.covariance = rotation * p.template topLeftCorner<kSize, kSize>() * rotation.transpose();
    if constexpr (kIsAided<State>) {
      constexpr int k = State::template index<ins::Odometer<double>>();
      const Eigen::Matrix<double, 6, 1> variance = p.diagonal().template segment<6>(k);
      // Without wheels it stays zero.
      if (variance.any())
        e.odometer =
            OdometerEstimate{x.odometer[0], x.odometer.template segment<2>(1),
                             x.odometer.template tail<3>(), variance.cwiseMax(0.0).cwiseSqrt()};
    }
    return e;
  }

  [[nodiscard]] GnssInsPoint point(const SO3d& q_body_imu) const {
    using namespace ins_state;
    GnssInsPoint point;
    point.nav = nav(q_body_imu);
    Eigen::Matrix<double, kSize, 1> variance = p.diagonal().template head<kSize>();
    const Eigen::Matrix3d r = q_body_imu.matrix();
    variance.segment<3>(kAttitude) =
        (r * p.template block<3, 3>(kAttitude, kAttitude) * r.transpose()).diagonal();
    point.sigma = variance.cwiseMax(0.0).cwiseSqrt().template cast<float>();
    point.imu_errors << x.gyro_bias_radps.template cast<float>(),
        x.accel_bias_mps2.template cast<float>(), x.gyro_scale.template cast<float>(),
        x.accel_scale.template cast<float>();
    point.clock_bias_m = clock_anchor_m + x.clock[0];
    point.clock_drift_mps = x.clock[1];
    return point;
  }
};

}  // namespace wayfare::nav
