#include <wayfare/logger/messages.hpp>

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include <wayfare/core/detail/bytes.hpp>

#include "io/text/text.hpp"
#include "logger/message_text.hpp"

namespace wayfare::logger {
namespace {

using nlohmann::json;
using namespace message_text;

/// Three numbers, NaN if the field is null or missing; nothing if it is something else.
std::optional<Eigen::Vector3d> vector_of(const json& message, const char* key) {
  const auto it = message.find(key);
  if (it == message.end() || it->is_null()) return Eigen::Vector3d::Constant(MargSample::kNone);
  if (!it->is_object()) return std::nullopt;
  const auto x = number(*it, "x"), y = number(*it, "y"), z = number(*it, "z");
  if (!x || !y || !z) return std::nullopt;
  return Eigen::Vector3d(*x, *y, *z);
}

}  // namespace

std::string json_escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      out += {'\\', c};
    } else if (code < 0x20 || code >= 0x7F) {
      // Bytes that are not ASCII may be invalid UTF-8.
      constexpr std::string_view kDigits = "0123456789abcdef";
      out += std::string("\\u00") + kDigits[code >> 4] + kDigits[code & 15U];
    } else {
      out += c;
    }
  }
  return out;
}

MessageSchema laser_scan_schema() {
  static const std::string schema =
      schema_json("foxglove.LaserScan", true,
                  R"("start_angle":{"type":"number"},"end_angle":{"type":"number"},)"
                  R"("ranges":{"type":"array","items":{"type":["number","null"]}},)"
                  R"("intensities":{"type":"array","items":{"type":"number"}},)"
                  R"("range_min":{"type":"number"},"range_max":{"type":"number"})");
  return {"foxglove.LaserScan", schema};
}

std::string laser_scan_json(const LaserScan& scan, std::string_view frame,
                            std::span<const float> intensities) {
  std::string out = head(scan.time, frame);
  out += kNoPose;
  const double first = scan.first_bearing.radians();
  const std::size_t beams = scan.ranges_m.size();
  out += R"(,"start_angle":)";
  put(out, first);
  out += R"(,"end_angle":)";
  put(out, first + scan.bearing_step.radians() * static_cast<double>(beams == 0 ? 0 : beams - 1));
  out += R"(,"range_min":)";
  put(out, scan.min_range_m);
  out += R"(,"range_max":)";
  put(out, scan.max_range_m);
  if (scan.is_sweep()) {
    out += R"(,"time_increment":)";
    put(out, to_seconds(scan.time_increment));
  }
  out += R"(,"ranges":[)";
  for (std::size_t i = 0; i < beams; ++i) {
    if (i != 0) out += ',';
    put(out, scan.ranges_m[i]);
  }
  out += R"(],"intensities":[)";
  for (std::size_t i = 0; i < intensities.size(); ++i) {
    if (i != 0) out += ',';
    put(out, intensities[i]);
  }
  return out + "]}";
}

Result<LaserScan> parse_laser_scan(std::string_view text) {
  const Error wrong = malformed("foxglove.LaserScan");
  const json message = json::parse(text, nullptr, false);
  const auto time = time_of(message);
  const auto first = number(message, "start_angle"), last = number(message, "end_angle");
  const auto ranges = message.find("ranges");
  if (!time || !first || !last || ranges == message.end() || !ranges->is_array()) return wrong;
  LaserScan scan;
  scan.time = *time;
  const auto steps = static_cast<double>(ranges->size() > 1 ? ranges->size() - 1 : 1);
  scan.first_bearing = Angle::radians(*first);
  scan.bearing_step = Angle::radians((*last - *first) / steps);
  constexpr auto kMost = std::numeric_limits<float>::max();
  scan.min_range_m = static_cast<float>(number(message, "range_min").value_or(0.0));
  scan.max_range_m = static_cast<float>(number(message, "range_max").value_or(double{kMost}));
  scan.time_increment = from_seconds(number(message, "time_increment").value_or(0.0));
  for (const json& range : *ranges) {
    if (!range.is_number() && !range.is_null()) return wrong;
    scan.ranges_m.push_back(range.is_null() ? std::numeric_limits<float>::quiet_NaN()
                                            : static_cast<float>(range.get<double>()));
  }
  return scan;
}

MessageSchema point_cloud_schema() {
  static const std::string schema = schema_json(
      "foxglove.PointCloud", true,
      R"("point_stride":{"type":"integer"},"fields":{"type":"array","items":)"
      R"({"title":"foxglove.PackedElementField","type":"object","properties":)"
      R"({"name":{"type":"string"},"offset":{"type":"integer"},"type":{"type":"integer"}}}},)"
      R"("data":{"type":"string","contentEncoding":"base64"})");
  return {"foxglove.PointCloud", schema};
}

std::string point_cloud_json(const RadarScan& scan, std::string_view frame,
                             std::span<const float> noise_db) {
  const bool noisy = noise_db.size() == scan.points.size() && !noise_db.empty();
  std::string out = head(scan.time, frame);
  out += kNoPose;
  // Type 7 is a 32-bit float.
  out += noisy ? R"(,"point_stride":24)" : R"(,"point_stride":20)";
  out += R"(,"fields":[{"name":"x","offset":0,"type":7},)"
         R"({"name":"y","offset":4,"type":7},{"name":"z","offset":8,"type":7},)"
         R"({"name":"doppler","offset":12,"type":7},{"name":"snr","offset":16,"type":7})";
  if (noisy) out += R"(,{"name":"noise","offset":20,"type":7})";
  out += R"(],"data":")";
  std::string bytes;
  for (std::size_t i = 0; i < scan.points.size(); ++i) {
    const RadarPoint& p = scan.points[i];
    for (const float v : {p.x_m, p.y_m, p.z_m, p.doppler_m_s, p.snr_db}) append_le(bytes, v);
    if (noisy) append_le(bytes, noise_db[i]);
  }
  return out + io::text::to_base64(bytes) + R"("})";
}

Result<RadarScan> parse_point_cloud(std::string_view text) {
  const Error wrong = malformed("foxglove.PointCloud of floats x, y, z, doppler, snr");
  const json message = json::parse(text, nullptr, false);
  const auto time = time_of(message);
  const auto stride = number(message, "point_stride");
  const auto data = message.find("data"), fields = message.find("fields");
  if (!time || !stride || data == message.end() || !data->is_string() || fields == message.end() ||
      !fields->is_array())
    return wrong;
  const auto bytes = from_base64(data->get_ref<const std::string&>());
  if (!bytes || !(*stride >= 12.0 && *stride <= 4096.0)) return wrong;
  const auto step = static_cast<std::size_t>(*stride);
  const auto offset_of = [&](const char* name) -> std::optional<std::size_t> {
    for (const json& field : *fields) {
      if (!field.is_object() || !field.contains("name") || field["name"] != name) continue;
      const auto at = number(field, "offset");
      const auto type = number(field, "type");
      if (at && *at >= 0.0 && *at <= *stride - 4.0 && type == 7.0)
        return static_cast<std::size_t>(*at);
    }
    return std::nullopt;
  };
  const auto x = offset_of("x"), y = offset_of("y"), z = offset_of("z");
  const auto doppler = offset_of("doppler"), snr = offset_of("snr");
  if (!x || !y || !z) return wrong;
  RadarScan scan{*time, {}};
  for (std::size_t at = 0; at + step <= bytes->size(); at += step) {
    const auto value = [&](std::optional<std::size_t> offset) {
      return offset ? decode::load_le<float>(bytes->data() + at + *offset) : 0.0F;
    };
    scan.points.push_back({value(x), value(y), value(z), value(doppler), value(snr)});
  }
  return scan;
}

MessageSchema imu_schema() {
  const auto vector = [](const char* name) {
    return std::string("\"") + name + R"(":{"type":["object","null"],"properties":{)" + numbers() +
           "}}";
  };
  static const std::string schema =
      schema_json("wayfare.Imu", false,
                  vector("angular_velocity") + "," + vector("linear_acceleration") + "," +
                      vector("magnetic_field"));
  return {"wayfare.Imu", schema};
}

std::string imu_json(const MargSample& sample, std::string_view frame) {
  std::string out = head(sample.time, frame);
  const auto vector = [&](const char* name, const Eigen::Vector3d& v) {
    out += std::string(",\"") + name + "\":";
    if (!v.allFinite()) {
      out += "null";
      return;
    }
    for (int i = 0; i < 3; ++i) {
      out += i == 0 ? "{\"" : ",\"";
      out += std::string(1, "xyz"[i]) + "\":";
      put(out, v[i]);
    }
    out += '}';
  };
  vector("angular_velocity", sample.angular_rate_radps);
  vector("linear_acceleration", sample.specific_force_mps2);
  vector("magnetic_field", sample.magnetic_field_uT);
  return out + '}';
}

Result<MargSample> parse_imu(std::string_view text) {
  const Error wrong = malformed("wayfare.Imu");
  const json message = json::parse(text, nullptr, false);
  const auto time = time_of(message);
  const auto rate = vector_of(message, "angular_velocity");
  const auto force = vector_of(message, "linear_acceleration");
  const auto field = vector_of(message, "magnetic_field");
  const bool any = message.contains("angular_velocity") ||
                   message.contains("linear_acceleration") || message.contains("magnetic_field");
  if (!time || !any || !rate || !force || !field) return wrong;
  return MargSample{*time, *rate, *force, *field};
}

}  // namespace wayfare::logger
