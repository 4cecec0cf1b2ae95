// Laser scans, inertial units and receivers.

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <wayfare/ros/convert.hpp>

namespace wayfare::ros {
namespace {

Error invalid(std::string what, std::string where) {
  return {ErrorCode::invalid, std::move(what), std::move(where)};
}

/// The angle that was rounded to a single-precision number of radians, if it can be determined.
Angle bearing_of(float radians) {
  const double degrees = Angle::radians(static_cast<double>(radians)).degrees();
  double scale = 1.0;
  for (int decimals = 0; decimals <= 7; ++decimals, scale *= 10.0) {
    const Angle shortest = Angle::degrees(std::round(degrees * scale) / scale);
    if (static_cast<float>(shortest.radians()) == radians) return shortest;
  }
  return Angle::radians(static_cast<double>(radians));
}

Eigen::Vector3d vector_of(const Vector3& v) { return {v.x, v.y, v.z}; }
Vector3 message_of(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

/// Converts between the order east, north, up of ROS and north, east, down.
Eigen::Matrix3d turned(const Eigen::Matrix3d& covariance) {
  const Eigen::Matrix3d turn{{0.0, 1.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 0.0, -1.0}};
  return turn * covariance * turn.transpose();
}

}  // namespace

Result<wayfare::LaserScan> laser_scan_of(const LaserScan& m, LogTime time) {
  if (!std::isfinite(m.angle_min) || !std::isfinite(m.angle_increment))
    return invalid("is not finite", "angle_min, angle_increment");
  if (!(m.range_min >= 0.0F && m.range_max > m.range_min))
    return invalid("do not enclose a range: " + std::to_string(m.range_min) + " to " +
                       std::to_string(m.range_max),
                   "range_min, range_max");
  const std::size_t beams = m.ranges.size();
  const double steps = beams == 0 ? 0.0 : static_cast<double>(beams - 1);
  if (std::abs(static_cast<double>(m.angle_increment)) * steps > 2.01 * std::numbers::pi ||
      (beams > 1 && m.angle_increment == 0.0F))
    return invalid("makes " + std::to_string(beams) + " beams no scan of at most a turn",
                   "angle_increment");
  wayfare::LaserScan scan;
  scan.time = time;
  if (m.time_increment > 0.0F && static_cast<double>(m.time_increment) * steps < 10.0)
    scan.time += from_seconds(0.5 * static_cast<double>(m.time_increment) * steps);
  scan.first_bearing = bearing_of(m.angle_min);
  scan.bearing_step = bearing_of(m.angle_increment);
  scan.min_range_m = m.range_min;
  scan.max_range_m = std::nextafter(m.range_max, std::numeric_limits<float>::infinity());
  scan.ranges_m = m.ranges;
  if (m.angle_increment < 0.0F) {
    scan.first_bearing += scan.bearing_step * steps;
    scan.bearing_step = -scan.bearing_step;
    std::reverse(scan.ranges_m.begin(), scan.ranges_m.end());
  }
  return scan;
}

LaserScan message_of(const wayfare::LaserScan& scan, std::string_view frame) {
  const std::size_t beams = scan.ranges_m.size();
  LaserScan m;
  m.header = header_of(scan.time, frame);
  m.angle_min = static_cast<float>(scan.first_bearing.radians());
  m.angle_max = static_cast<float>(scan.bearing(beams == 0 ? 0 : beams - 1).radians());
  m.angle_increment = static_cast<float>(scan.bearing_step.radians());
  m.range_min = scan.min_range_m;
  m.range_max = std::nextafter(scan.max_range_m, 0.0F);
  m.ranges = scan.ranges_m;
  return m;
}

Result<Eigen::Vector3d> turn_rate_of(const Imu& m) {
  if (m.angular_velocity_covariance[0] == -1.0)
    return invalid("marks turn rate as not measured", "covariance");
  const Eigen::Vector3d rate = vector_of(m.angular_velocity);
  if (!rate.allFinite()) return invalid("is not finite", "angular_velocity");
  return rate;
}

Result<ImuSample> imu_of(const Imu& m, LogTime time) {
  const auto rate = turn_rate_of(m);
  if (!rate) return rate.error();
  if (m.linear_acceleration_covariance[0] == -1.0)
    return invalid("marks specific force as not measured", "covariance");
  const ImuSample sample{time, *rate, vector_of(m.linear_acceleration)};
  if (!sample.specific_force_mps2.allFinite())
    return invalid("is not finite", "linear_acceleration");
  return sample;
}

Imu message_of(const ImuSample& sample, std::string_view frame) {
  Imu m;
  m.header = header_of(sample.time, frame);
  m.orientation.w = 1.0;
  m.orientation_covariance[0] = -1.0;
  m.angular_velocity = message_of(sample.angular_rate_radps);
  m.linear_acceleration = message_of(sample.specific_force_mps2);
  return m;
}

Imu message_of(const GyroSample& sample, std::string_view frame) {
  Imu m = message_of(ImuSample{sample.time, {0.0, 0.0, sample.turn_rate_rad_s}, {0.0, 0.0, 0.0}},
                     frame);
  m.linear_acceleration_covariance[0] = -1.0;
  return m;
}

Eigen::Vector3d field_uT_of(const MagneticField& message) {
  return vector_of(message.magnetic_field) * 1e6;
}

MagneticField magnetic_message_of(const Eigen::Vector3d& field_uT, LogTime time,
                                  std::string_view frame) {
  MagneticField m;
  m.header = header_of(time, frame);
  m.magnetic_field = message_of(Eigen::Vector3d(field_uT * 1e-6));
  return m;
}

Result<GnssFix> fix_of(const NavSatFix& m, LogTime time) {
  if (m.status.status < 0) return invalid("has no fix", "status");
  if (!(std::abs(m.latitude) <= 90.0 && std::abs(m.longitude) <= 360.0 &&
        std::isfinite(m.altitude)))
    return invalid("is no position on the Earth", "latitude, longitude, altitude");
  GnssFix fix;
  fix.time = time;
  fix.position = {Angle::degrees(m.latitude), Angle::degrees(m.longitude), m.altitude};
  const Eigen::Matrix3d covariance =
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(m.position_covariance.data());
  if (m.position_covariance_type != 0) {
    if (!covariance.allFinite() || !(covariance.diagonal().minCoeff() > 0.0))
      return invalid("has no positive variances", "position_covariance");
    fix.position_covariance_ned_m2 = turned(covariance);
  }
  return fix;
}

NavSatFix message_of(const GnssFix& fix, std::string_view frame) {
  NavSatFix m;
  m.header = header_of(fix.time, frame);
  m.status.service = 1;
  m.latitude = fix.position.latitude.degrees();
  m.longitude = fix.position.longitude.degrees();
  m.altitude = fix.position.height_m;
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(m.position_covariance.data()) =
      turned(fix.position_covariance_ned_m2);
  m.position_covariance_type = 3;
  return m;
}

}  // namespace wayfare::ros
