// Radar points, as arrays and as point clouds of any layout.

#include <bit>
#include <cmath>
#include <cstring>

#include <wayfare/ros/convert.hpp>

#include "ros/serialise/archive.hpp"

namespace wayfare::ros {
namespace {

Error invalid(std::string what, std::string where) {
  return {ErrorCode::invalid, std::move(what), std::move(where)};
}

/// Offset and type of a number in each point.
struct Field {
  std::size_t offset = 0;
  std::uint8_t datatype = 0;
};

constexpr std::size_t kSizes[] = {0, 1, 1, 2, 2, 4, 4, 4, 8};

template <class T>
double number_at(const std::uint8_t* bytes, bool big_endian) {
  T raw;
  std::memcpy(&raw, bytes, sizeof(T));
  return static_cast<double>(std::bit_cast<T>(wire_bytes(raw, big_endian)));
}

double value_of(const Field& field, const std::uint8_t* point, bool big) {
  const std::uint8_t* at = point + field.offset;
  switch (field.datatype) {
    case 1:
      return number_at<std::int8_t>(at, big);
    case 2:
      return number_at<std::uint8_t>(at, big);
    case 3:
      return number_at<std::int16_t>(at, big);
    case 4:
      return number_at<std::uint16_t>(at, big);
    case 5:
      return number_at<std::int32_t>(at, big);
    case 6:
      return number_at<std::uint32_t>(at, big);
    case 7:
      return number_at<float>(at, big);
    case 8:
      return number_at<double>(at, big);
    default:
      return 0.0;
  }
}

/// The first of `names` among the fields; a field beyond the end of the point is not valid.
std::optional<Field> field_of(const PointCloud2& cloud,
                              std::initializer_list<std::string_view> names) {
  for (const std::string_view name : names)
    for (const PointField& f : cloud.fields_of_point) {
      if (f.name != name || f.datatype < 1 || f.datatype > 8) continue;
      const std::size_t size = kSizes[f.datatype];
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

Result<wayfare::RadarScan> radar_scan_of(const PointCloud2& cloud, LogTime time) {
  const auto x = field_of(cloud, {"x"}), y = field_of(cloud, {"y"}), z = field_of(cloud, {"z"});
  if (!x || !y || !z) return invalid("have no x, y and z within a point", "fields");
  const auto speed = field_of(cloud, {"velocity", "doppler", "v_doppler_mps"});
  const auto strength = field_of(cloud, {"intensity", "snr", "snr_db"});
  if (auto ok = check_sizes(cloud); !ok) return ok.error();
  wayfare::RadarScan scan{time, {}};
  for (std::uint64_t row = 0; row < cloud.height; ++row)
    for (std::uint64_t column = 0; column < cloud.width; ++column) {
      const std::uint8_t* point =
          cloud.data.data() + row * cloud.row_step + column * cloud.point_step;
      const auto get = [&](const std::optional<Field>& f) {
        return f ? static_cast<float>(value_of(*f, point, cloud.is_bigendian)) : 0.0F;
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
    for (const float v : {p.x_m, p.y_m, p.z_m, p.snr_db, p.doppler_m_s})
      for (const char byte : wire_bytes(v, false))
        cloud.data.push_back(static_cast<std::uint8_t>(byte));
  cloud.is_dense = true;
  return cloud;
}

}  // namespace wayfare::ros
