#include <wayfare/sim/vehicle_trajectory.hpp>

#include <cmath>

#include <wayfare/core/so3.hpp>

namespace wayfare::sim {
namespace {

// Earth rate in local level.
Eigen::Vector3d earth_rate_ned(double latitude) {
  return {wgs84::kEarthRate_radps * std::cos(latitude), 0.0,
          -wgs84::kEarthRate_radps * std::sin(latitude)};
}

// Transport rate: rotation of local level due to motion over the Earth (Groves 2013, (5.44)).
Eigen::Vector3d transport_rate_ned(const Geodetic& p, const Eigen::Vector3d& v) {
  const double s = std::sin(p.latitude.radians()), t = std::tan(p.latitude.radians());
  const double rn = transverse_radius_m(s) + p.height_m, rm = meridian_radius_m(s) + p.height_m;
  return {v.y() / rn, -v.x() / rm, -v.y() * t / rn};
}

// Rate of the body relative to local level, in body axes, from roll, pitch, yaw and their rates.
Eigen::Vector3d body_rate(const Eigen::Vector3d& rpy, const Eigen::Vector3d& rate) {
  const double sr = std::sin(rpy[0]), cr = std::cos(rpy[0]);
  const double sp = std::sin(rpy[1]), cp = std::cos(rpy[1]);
  return {rate[0] - rate[2] * sp, rate[1] * cr + rate[2] * sr * cp,
          -rate[1] * sr + rate[2] * cr * cp};
}

}  // namespace

VehicleMotion VehicleTrajectory::motion(LogTime time) const {
  const double t = to_seconds(time - start_);
  const SmoothCurve::Point p = position_.at(t), a = attitude_.at(t);
  VehicleMotion m;
  m.nav.time = time;
  m.nav.position = geodetic_from_ned(p.value, origin_);
  const Eigen::Matrix3d ned_origin =
      rotation_ecef_ned(m.nav.position).transpose() * rotation_ecef_ned(origin_);
  const Eigen::Vector3d v = ned_origin * p.first;
  m.nav.velocity_ned_mps = v;
  m.nav.q_nb = rotation_from_roll_pitch_yaw(a.value);

  // The curve's second derivative is the acceleration in Earth-fixed axes, so only Coriolis is
  // missing; the centrifugal part is in gravity.
  const double latitude = m.nav.position.latitude.radians();
  const Eigen::Vector3d w_ie = earth_rate_ned(latitude);
  const Eigen::Vector3d gravity(0.0, 0.0,
                                normal_gravity_mps2(std::sin(latitude), m.nav.position.height_m));
  const SO3d q_bn = m.nav.q_nb.inverse();
  m.specific_force_mps2 = q_bn * (ned_origin * p.second + 2.0 * w_ie.cross(v) - gravity).eval();
  m.angular_rate_radps =
      body_rate(a.value, a.first) + q_bn * (w_ie + transport_rate_ned(m.nav.position, v)).eval();
  return m;
}

EcefMotion ecef_motion(const VehicleMotion& m, const Eigen::Vector3d& lever_arm_body_m) {
  const Eigen::Matrix3d ecef_ned = rotation_ecef_ned(m.nav.position);
  const Eigen::Vector3d w_ie(0.0, 0.0, wgs84::kEarthRate_radps);
  const Eigen::Matrix3d ecef_body = ecef_ned * m.nav.q_nb.matrix();
  const Eigen::Vector3d arm = ecef_body * lever_arm_body_m;
  const Eigen::Vector3d w_eb = ecef_body * m.angular_rate_radps - w_ie;
  return {ecef_from_geodetic(m.nav.position) + arm,
          ecef_ned * m.nav.velocity_ned_mps + w_eb.cross(arm)};
}

}  // namespace wayfare::sim
