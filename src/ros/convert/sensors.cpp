// Laser scans, radar points (as arrays and as clouds of any layout), inertial units and receivers.

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <numbers>
#include <optional>
#include <string_view>

#include <wayfare/core/detail/bytes.hpp>
#include <wayfare/core/gaussian.hpp>
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
Vector3 vector_message(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

/// Converts between the order east, north, up of ROS and north, east, down.
Eigen::Matrix3d turned(const Eigen::Matrix3d& covariance) {
  const Eigen::Matrix3d turn{{0.0, 1.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 0.0, -1.0}};
  return turn * covariance * turn.transpose();
}

template <class T>
double number_at(const std::uint8_t* bytes, bool big_endian) {
  return static_cast<double>(big_endian ? decode::load_be<T>(bytes) : decode::load_le<T>(bytes));
}

/// The types of numbers in a point, by their constants in sensor_msgs/PointField.
struct NumberType {
  std::size_t size = 0;
  double (*read)(const std::uint8_t* bytes, bool big_endian) = nullptr;
};
constexpr NumberType kTypes[] = {{},
                                 {1, number_at<std::int8_t>},
                                 {1, number_at<std::uint8_t>},
                                 {2, number_at<std::int16_t>},
                                 {2, number_at<std::uint16_t>},
                                 {4, number_at<std::int32_t>},
                                 {4, number_at<std::uint32_t>},
                                 {4, number_at<float>},
                                 {8, number_at<double>}};

/// Offset and type of a number in each point.
struct Field {
  std::size_t offset = 0;
  std::uint8_t datatype = 0;
};

/// The first of `names` among the fields; a field beyond the end of the point is not valid.
std::optional<Field> field_of(const PointCloud2& cloud,
                              std::initializer_list<std::string_view> names) {
  for (const std::string_view name : names)
    for (const PointField& f : cloud.fields_of_point) {
      if (f.name != name || f.datatype < 1 || f.datatype > 8) continue;
      const std::size_t size = kTypes[f.datatype].size;
      if (cloud.point_step >= size && f.offset <= cloud.point_step - size)
        return Field{f.offset, f.datatype};
    }
  return std::nullopt;
}

Result<void> check_sizes(const PointCloud2& c) {
  const std::uint64_t row = std::uint64_t{c.width} * c.point_step;
  if (c.width == 0 || c.height == 0) return {};
  const std::uint64_t step = c.height == 1 ? row : c.row_step;
  if (c.point_step == 0 || step < row || c.data.size() < row ||
      (c.height > 1 && (c.data.size() - row) / step < c.height - 1))
    return invalid("has " + std::to_string(c.data.size()) + " bytes for " +
                       std::to_string(c.width) + " x " + std::to_string(c.height) + " points of " +
                       std::to_string(c.point_step),
                   "data");
  return {};
}

bool is_finite(const RadarPoint& p) {
  return std::isfinite(p.x_m) && std::isfinite(p.y_m) && std::isfinite(p.z_m) &&
         std::isfinite(p.doppler_m_s) && std::isfinite(p.snr_db);
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
  if (m.time_increment > 0.0F && static_cast<double>(m.time_increment) * steps < 10.0) {
    scan.time += from_seconds(0.5 * static_cast<double>(m.time_increment) * steps);
    scan.time_increment = from_seconds(static_cast<double>(m.time_increment));
  }
  scan.first_bearing = bearing_of(m.angle_min);
  scan.bearing_step = bearing_of(m.angle_increment);
  scan.min_range_m = m.range_min;
  scan.max_range_m = std::nextafter(m.range_max, std::numeric_limits<float>::infinity());
  scan.ranges_m = m.ranges;
  if (m.angle_increment < 0.0F) {
    scan.first_bearing += scan.bearing_step * steps;
    scan.bearing_step = -scan.bearing_step;
    scan.time_increment = -scan.time_increment;
    std::reverse(scan.ranges_m.begin(), scan.ranges_m.end());
  }
  return scan;
}

namespace {

/// The message is in the order of time: its stamp is that of the first beam measured.
void add_times(const wayfare::LaserScan& scan, LaserScan& m) {
  m.time_increment = static_cast<float>(std::abs(to_seconds(scan.time_increment)));
  m.header.stamp = stamp_of(scan.time - from_seconds(0.5 * scan.sweep_s()));
  if (scan.time_increment > Duration::zero()) return;
  std::swap(m.angle_min, m.angle_max);
  m.angle_increment = -m.angle_increment;
  std::reverse(m.ranges.begin(), m.ranges.end());
}

}  // namespace

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
  if (scan.is_sweep()) add_times(scan, m);
  return m;
}

Result<wayfare::RadarScan> radar_scan_of(const PointCloud2& cloud, LogTime time) {
  const auto x = field_of(cloud, {"x"}), y = field_of(cloud, {"y"}), z = field_of(cloud, {"z"});
  if (!x || !y || !z) return invalid("have no x, y and z within a point", "fields");
  const auto speed = field_of(cloud, {"velocity", "doppler", "v_doppler_mps"});
  const auto strength = field_of(cloud, {"intensity", "snr", "snr_db"});
  if (auto ok = check_sizes(cloud); !ok) return ok.error();
  wayfare::RadarScan scan{time, {}};
  if (cloud.width == 0) return scan;  // of any height
  for (std::uint64_t row = 0; row < cloud.height; ++row)
    for (std::uint64_t column = 0; column < cloud.width; ++column) {
      const std::uint8_t* point =
          cloud.data.data() + row * cloud.row_step + column * cloud.point_step;
      const auto get = [&](const std::optional<Field>& f) {
        if (!f) return 0.0F;
        return static_cast<float>(kTypes[f->datatype].read(point + f->offset, cloud.is_bigendian));
      };
      const RadarPoint p{get(x), get(y), get(z), get(speed), get(strength)};
      if (is_finite(p)) scan.points.push_back(p);
    }
  return scan;
}

Result<wayfare::RadarScan> radar_scan_of(const RadarScan& m, LogTime time) {
  for (const auto* list : {&m.x, &m.y, &m.z, &m.intensities, &m.velocities})
    if (list->size() != m.width)
      return invalid("has an array of " + std::to_string(list->size()) + " for a width of " +
                         std::to_string(m.width),
                     "width");
  wayfare::RadarScan scan{time, {}};
  for (std::size_t i = 0; i < m.width; ++i) {
    const RadarPoint p{m.x[i], m.y[i], m.z[i], m.velocities[i], m.intensities[i]};
    if (is_finite(p)) scan.points.push_back(p);
  }
  return scan;
}

RadarScan message_of(const wayfare::RadarScan& scan, std::string_view frame) {
  RadarScan m;
  m.header = header_of(scan.time, frame);
  m.width = static_cast<std::uint32_t>(scan.points.size());
  for (const RadarPoint& p : scan.points) {
    m.x.push_back(p.x_m);
    m.y.push_back(p.y_m);
    m.z.push_back(p.z_m);
    m.intensities.push_back(p.snr_db);
    m.velocities.push_back(p.doppler_m_s);
  }
  return m;
}

PointCloud2 cloud_of(const wayfare::RadarScan& scan, std::string_view frame) {
  PointCloud2 cloud;
  cloud.header = header_of(scan.time, frame);
  cloud.height = 1;
  cloud.width = static_cast<std::uint32_t>(scan.points.size());
  for (const char* name : {"x", "y", "z", "intensity", "velocity"}) {
    cloud.fields_of_point.push_back({name, cloud.point_step, 7, 1});
    cloud.point_step += 4;
  }
  cloud.row_step = cloud.point_step * cloud.width;
  for (const RadarPoint& p : scan.points)
    for (const float v : {p.x_m, p.y_m, p.z_m, p.snr_db, p.doppler_m_s}) {
      std::uint8_t bytes[sizeof v];
      decode::store_le(v, bytes);
      cloud.data.insert(cloud.data.end(), bytes, bytes + sizeof v);
    }
  cloud.is_dense = true;
  return cloud;
}

wayfare::RadarScan turned_over(wayfare::RadarScan scan) {
  for (RadarPoint& p : scan.points) p.y_m = -p.y_m, p.z_m = -p.z_m;
  return scan;
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
  m.angular_velocity = vector_message(sample.angular_rate_radps);
  m.linear_acceleration = vector_message(sample.specific_force_mps2);
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
  m.magnetic_field = vector_message(field_uT * 1e-6);
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
    Eigen::Matrix3d& used = fix.position_covariance_ned_m2;
    if (!is_positive_definite(used)) used = Eigen::Matrix3d(used.diagonal().asDiagonal());
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
