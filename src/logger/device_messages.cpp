#include <wayfare/logger/device_messages.hpp>

#include <algorithm>
#include <array>
#include <utility>

#include <nlohmann/json.hpp>

#include <wayfare/decode/ti_items.hpp>
#include <wayfare/io/mcap.hpp>

#include "logger/message_text.hpp"
#include "logger/packed_fields.hpp"

namespace wayfare::logger {
namespace {

using nlohmann::json;
using namespace message_text;

constexpr std::size_t kNodeBytes = 14;
/// Angle, distance, time, quality, start; types as of foxglove.PackedElementField.
constexpr std::string_view kNodeFields =
    R"([{"name":"angle","offset":0,"type":7},{"name":"distance","offset":4,"type":5},)"
    R"({"name":"time","offset":8,"type":5},{"name":"quality","offset":12,"type":1},)"
    R"({"name":"start","offset":13,"type":1}])";

constexpr std::string_view kPackedFields =
    R"("point_stride":{"type":"integer"},"fields":{"type":"array","items":)"
    R"({"title":"foxglove.PackedElementField","type":"object","properties":)"
    R"({"name":{"type":"string"},"offset":{"type":"integer"},"type":{"type":"integer"}}}},)"
    R"("data":{"type":"string","contentEncoding":"base64"})";

template <class T, class Numbers>
std::vector<T> values_of(const Numbers& numbers) {
  std::vector<T> values(numbers.size());
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = numbers[i];
  return values;
}

/// `,"name":"base64"` of 16-bit numbers, if there are any.
template <class T>
void add_packed(std::string& out, const char* name, const std::vector<T>& values) {
  if (values.empty()) return;
  std::string bytes;
  for (const T value : values) append_le(bytes, value);
  out += std::string(",\"") + name + "\":\"" + io::text::to_base64(bytes) + '"';
}

template <class T>
bool read_packed(const json& from, const char* name, std::vector<T>& values) {
  const auto it = from.find(name);
  if (it == from.end()) return true;
  if (!it->is_string()) return false;
  const auto bytes = from_base64(it->get_ref<const std::string&>());
  if (!bytes || bytes->size() % sizeof(T) != 0) return false;
  for (std::size_t at = 0; at < bytes->size(); at += sizeof(T))
    values.push_back(decode::load_le<T>(bytes->data() + at));
  return true;
}

constexpr auto kStatisticsFields = [](auto& s, auto& field) {
  field("processing_us", s.processing_us);
  field("transmit_us", s.transmit_us);
  field("frame_margin_us", s.frame_margin_us);
  field("chirp_margin_us", s.chirp_margin_us);
  field("active_load_percent", s.active_load_percent);
  field("idle_load_percent", s.idle_load_percent);
};

constexpr std::array<const char*, 10> kTemperatures = {
    "rx0_c", "rx1_c", "rx2_c", "rx3_c", "tx0_c", "tx1_c", "tx2_c", "pm_c", "dig0_c", "dig1_c"};
constexpr auto kTemperatureFields = [](auto& t, auto& field) {
  field("valid", t.valid);
  field("time_ms", t.time_ms);
  for (std::size_t i = 0; i < kTemperatures.size(); ++i) field(kTemperatures[i], t.celsius[i]);
};

constexpr auto kRadarFields = [](auto& r, auto& field) {
  field("number", r.number);
  field("subframe", r.subframe);
  field("platform", r.platform);
  field("version", r.version);
  field("points", r.points);
  field("range_profile", r.range_profile);
  field("noise_profile", r.noise_profile);
  field("linear_profile", r.linear_profile);
  field("target_index", r.target_index);
  field("presence", r.presence);
};

constexpr auto kTargetFields = [](auto& t, auto& field) {
  field("id", t.id);
  constexpr std::array<std::array<const char*, 3>, 3> kNames = {
      {{"x", "y", "z"}, {"vx", "vy", "vz"}, {"ax", "ay", "az"}}};
  for (std::size_t i = 0; i < 3; ++i) {
    field(kNames[0][i], t.position_m[i]);
    field(kNames[1][i], t.velocity_mps[i]);
    field(kNames[2][i], t.acceleration_mps2[i]);
  }
  field("gain", t.gain);
  field("confidence", t.confidence);
};

bool read_targets(const json& from, std::vector<decode::TiTarget>& targets) {
  const auto it = from.find("targets");
  if (it == from.end()) return true;
  if (!it->is_array()) return false;
  for (const json& element : *it) {
    if (!element.is_object()) return false;
    FieldReader reader(element);
    kTargetFields(targets.emplace_back(), reader);
    if (!reader.good()) return false;
  }
  return true;
}

}  // namespace

MessageSchema lidar_nodes_schema() {
  static const std::string schema =
      schema_json("wayfare.LidarNodes", false, std::string(kPackedFields));
  return {"wayfare.LidarNodes", schema};
}

std::string lidar_nodes_json(std::span<const decode::TimedRplidarPoint> points,
                             std::string_view frame) {
  const LogTime first = points.empty() ? LogTime() : points.front().time;
  std::string out = head(first, frame);
  out += R"(,"point_stride":14,"fields":)";
  out += kNodeFields;
  std::string bytes;
  bytes.reserve(kNodeBytes * points.size());
  for (const decode::TimedRplidarPoint& p : points) {
    const std::int64_t after = std::clamp<std::int64_t>((p.time - first).count(), 0, 0xFFFFFFFF);
    append_le(bytes, static_cast<float>(p.point.angle_deg()));
    append_le(bytes, p.point.distance_q2);
    append_le(bytes, static_cast<std::uint32_t>(after));
    append_le(bytes, p.point.quality);
    append_le(bytes, static_cast<std::uint8_t>(p.point.start_of_revolution ? 1 : 0));
  }
  return out + R"(,"data":")" + io::text::to_base64(bytes) + R"("})";
}

Result<std::vector<decode::TimedRplidarPoint>> parse_lidar_nodes(std::string_view text) {
  const Error wrong = malformed("wayfare.LidarNodes");
  const json message = json::parse(text, nullptr, false);
  const auto time = time_of(message);
  const auto stride = number(message, "point_stride");
  const auto data = message.find("data"), fields = message.find("fields");
  if (!time || stride != static_cast<double>(kNodeBytes) || data == message.end() ||
      !data->is_string() || fields == message.end() || *fields != json::parse(kNodeFields))
    return wrong;
  const auto bytes = from_base64(data->get_ref<const std::string&>());
  if (!bytes || bytes->size() % kNodeBytes != 0) return wrong;
  std::vector<decode::TimedRplidarPoint> points;
  for (std::size_t at = 0; at < bytes->size(); at += kNodeBytes) {
    const std::uint8_t* p = bytes->data() + at;
    const double fine = 8192.0 * double{decode::load_le<float>(p)};
    if (!(fine >= 0.0 && fine < 8192.0 * 360.0)) return wrong;
    const auto q13 = static_cast<std::uint32_t>(fine);
    points.push_back({{static_cast<std::uint16_t>(q13 >> 7), decode::load_le<std::uint32_t>(p + 4),
                       p[12], p[13] != 0, static_cast<std::uint8_t>(q13 & 0x7FU)},
                      *time + Duration(decode::load_le<std::uint32_t>(p + 8))});
  }
  return points;
}

RadarFrame radar_frame(const decode::TiFrame& frame, LogTime time) {
  const decode::TiHeader& h = frame.header();
  RadarFrame r{time,
               h.frame_number,
               h.subframe,
               h.platform,
               h.version,
               static_cast<std::uint32_t>(frame.size()),
               frame.statistics(),
               frame.temperature(),
               {},
               {},
               {},
               {},
               {},
               {},
               {},
               decode::ti_presence(frame)};
  r.linear_profile = values_of<std::uint32_t>(decode::ti_linear_profile(frame));
  if (h.layout == decode::TiLayout::demo) {  // others use the numbers of these items for targets
    r.range_profile = values_of<std::uint16_t>(decode::ti_range_profile(frame));
    r.noise_profile = values_of<std::uint16_t>(decode::ti_noise_profile(frame));
    r.range_doppler_map = values_of<std::uint16_t>(decode::ti_range_doppler_map(frame));
    r.azimuth_map = values_of<std::int16_t>(decode::ti_azimuth_map(frame));
  } else {
    r.statistics.reset();
    r.temperature.reset();
  }
  r.targets = values_of<decode::TiTarget>(decode::ti_targets(frame));
  const decode::Bytes index = decode::ti_target_index(frame);
  r.target_index.assign(index.begin(), index.end());
  return r;
}

MessageSchema radar_frame_schema() {
  static const std::string schema =
      schema_json("wayfare.RadarFrame", false,
                  R"("number":{"type":"integer"},"points":{"type":"integer"},)"
                  R"("statistics":{"type":"object"},"temperature":{"type":"object"},)"
                  R"("range_profile":{"type":"array","items":{"type":"integer"}},)"
                  R"("noise_profile":{"type":"array","items":{"type":"integer"}},)"
                  R"("range_doppler_map":{"type":"string","contentEncoding":"base64"},)"
                  R"("azimuth_map":{"type":"string","contentEncoding":"base64"},)"
                  R"("targets":{"type":"array","items":{"type":"object"}})");
  return {"wayfare.RadarFrame", schema};
}

std::string radar_frame_json(const RadarFrame& radar, std::string_view frame) {
  std::string out = head(radar.time, frame);
  FieldWriter writer(out);
  kRadarFields(radar, writer);
  add_object(out, "statistics", radar.statistics, kStatisticsFields);
  add_object(out, "temperature", radar.temperature, kTemperatureFields);
  add_packed(out, "range_doppler_map", radar.range_doppler_map);
  add_packed(out, "azimuth_map", radar.azimuth_map);
  if (!radar.targets.empty()) {
    out += R"(,"targets":[)";
    for (const decode::TiTarget& target : radar.targets) {
      std::string fields;
      FieldWriter of_target(fields);
      kTargetFields(target, of_target);
      out += (out.back() == '[' ? "{" : ",{") + fields.substr(1) + '}';
    }
    out += ']';
  }
  return out + '}';
}

Result<RadarFrame> parse_radar_frame(std::string_view text) {
  const json message = json::parse(text, nullptr, false);
  const auto time = time_of(message);
  if (!time || !message.contains("number")) return malformed("wayfare.RadarFrame");
  RadarFrame r;
  r.time = *time;
  FieldReader reader(message);
  kRadarFields(r, reader);
  if (!reader.good() || !read_object(message, "statistics", r.statistics, kStatisticsFields) ||
      !read_object(message, "temperature", r.temperature, kTemperatureFields) ||
      !read_packed(message, "range_doppler_map", r.range_doppler_map) ||
      !read_packed(message, "azimuth_map", r.azimuth_map) || !read_targets(message, r.targets))
    return malformed("wayfare.RadarFrame");
  return r;
}

}  // namespace wayfare::logger
