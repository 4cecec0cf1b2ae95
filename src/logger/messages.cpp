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
#include "logger/time_parts.hpp"

namespace wayfare::logger {
namespace {

using nlohmann::json;

constexpr std::int64_t kSecond = 1'000'000'000;
constexpr std::string_view kNoPose =
    R"(,"pose":{"position":{"x":0,"y":0,"z":0},"orientation":{"x":0,"y":0,"z":0,"w":1}})";

Error malformed(const char* what) { return Error{ErrorCode::parse, std::string("is no ") + what}; }

/// The shortest text that is read back as the same number.
template <class Number>
void put(std::string& out, Number value) {
  if (std::isfinite(value)) {
    io::text::append_number(out, value);
  } else {
    out += "null";
  }
}

/// The beginning of a message: its time and frame.
std::string head(LogTime time, std::string_view frame) {
  const auto [sec, nsec] = seconds_and_rest(time);
  std::string out = R"({"timestamp":{"sec":)";
  put(out, sec);
  out += R"(,"nsec":)";
  put(out, nsec);
  out += R"(},"frame_id":")" + json_escaped(frame) + '"';
  return out;
}

/// Numbers x, y, z, and those in `more`, as properties of a schema.
std::string numbers(std::string_view more = {}) {
  std::string out;
  for (const char c : std::string("xyz") + std::string(more))
    out += std::string(out.empty() ? "" : ",") + '"' + c + R"(":{"type":"number"})";
  return out;
}

/// The schema of a message with time, frame, optional pose, and `fields`.
std::string schema_json(const std::string& name, bool posed, const std::string& fields) {
  std::string out = R"({"title":")" + name + R"(","type":"object","properties":{)";
  out += R"("timestamp":{"type":"object","title":"time","properties":)";
  out += R"({"sec":{"type":"integer"},"nsec":{"type":"integer"}}},"frame_id":{"type":"string"},)";
  if (posed) {
    out += R"("pose":{"title":"foxglove.Pose","type":"object","properties":{)";
    out += R"("position":{"title":"foxglove.Vector3","type":"object","properties":{)" + numbers() +
           R"(}},"orientation":{"title":"foxglove.Quaternion","type":"object","properties":{)" +
           numbers("w") + "}}}},";
  }
  return out + fields + "}}";
}

std::optional<std::vector<std::uint8_t>> from_base64(std::string_view text) {
  std::vector<std::uint8_t> out;
  std::uint32_t bits = 0;
  int held = 0;
  while (!text.empty() && text.back() == '=') text.remove_suffix(1);
  for (const char c : text) {
    const std::size_t value = io::text::kBase64Digits.find(c);
    if (value == text.npos) return std::nullopt;
    bits = bits << 6 | static_cast<std::uint32_t>(value);
    held += 6;
    if (held < 8) continue;
    held -= 8;
    out.push_back(static_cast<std::uint8_t>(bits >> held));
  }
  return out;
}

std::optional<double> number(const json& from, const char* key) {
  const auto it = from.find(key);
  if (it == from.end() || !it->is_number()) return std::nullopt;
  return it->get<double>();
}

std::optional<LogTime> time_of(const json& message) {
  const auto it = message.find("timestamp");
  if (it == message.end() || !it->is_object()) return std::nullopt;
  const auto sec = it->find("sec"), nsec = it->find("nsec");
  if (sec == it->end() || nsec == it->end() || !sec->is_number_integer() ||
      !nsec->is_number_integer())
    return std::nullopt;
  // An unsigned number above the limit of a signed one would be taken for a negative one.
  const auto too_large = [](const json& n) {
    return n.is_number_unsigned() && n.get<std::uint64_t>() > 9'000'000'000;
  };
  if (too_large(*sec) || too_large(*nsec)) return std::nullopt;
  const auto s = sec->get<std::int64_t>(), ns = nsec->get<std::int64_t>();
  if (s < -9'000'000'000 || s > 9'000'000'000 || ns < 0 || ns >= kSecond) return std::nullopt;
  return LogTime::from_nanoseconds(s * kSecond + ns);
}

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

std::string laser_scan_json(const LaserScan& scan, std::string_view frame) {
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
  return out + R"(],"intensities":[]})";
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

std::string point_cloud_json(const RadarScan& scan, std::string_view frame) {
  std::string out = head(scan.time, frame);
  out += kNoPose;
  // Type 7 is a 32-bit float.
  out += R"(,"point_stride":20,"fields":[{"name":"x","offset":0,"type":7},)"
         R"({"name":"y","offset":4,"type":7},{"name":"z","offset":8,"type":7},)"
         R"({"name":"doppler","offset":12,"type":7},{"name":"snr","offset":16,"type":7}],"data":")";
  std::string bytes;
  for (const RadarPoint& p : scan.points)
    for (const float v : {p.x_m, p.y_m, p.z_m, p.doppler_m_s, p.snr_db}) {
      std::array<std::uint8_t, sizeof v> raw;
      decode::store_le(v, raw.data());
      bytes.append(raw.begin(), raw.end());
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
