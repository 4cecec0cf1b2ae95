#include <wayfare/logger/device_messages.hpp>

#include <nlohmann/json.hpp>

#include "logger/message_text.hpp"
#include "logger/packed_fields.hpp"

namespace wayfare::logger {
namespace {

using nlohmann::json;
using namespace message_text;

/// Counters and times, which are no content of their own.
constexpr auto kClockFields = [](auto& s, auto& field) {
  field("packet_counter", s.packet_counter);
  field("frame_counter", s.frame_counter);
  field("sample_time_fine", s.sample_time_fine);
  field("sample_time_coarse", s.sample_time_coarse);
  field("sample_time_64", s.sample_time_64);
};

constexpr auto kContentFields = [](auto& s, auto& field) {
  field("itow_ms", s.itow_ms);
  field("status_byte", s.status_byte);
  field("status_word", s.status_word);
  field("temperature_c", s.temperature_c);
  field("pressure_pa", s.pressure_pa);
  field("quaternion", s.quaternion);
  field("euler_deg", s.euler_deg);
  field("rotation_matrix", s.rotation_matrix);
  field("free_acceleration_mps2", s.free_acceleration_mps2);
  field("delta_v_mps", s.delta_v_mps);
  field("delta_q", s.delta_q);
  field("acceleration_hr_mps2", s.acceleration_hr_mps2);
  field("rate_hr_radps", s.rate_hr_radps);
  field("lat_lon_deg", s.lat_lon_deg);
  field("altitude_msl_m", s.altitude_msl_m);
  field("altitude_ellipsoid_m", s.altitude_ellipsoid_m);
  field("position_ecef_m", s.position_ecef_m);
  field("velocity_mps", s.velocity_mps);
  field("rssi_dbm", s.rssi_dbm);
};

constexpr auto kUtcFields = [](auto& u, auto& field) {
  field("year", u.year);
  field("month", u.month);
  field("day", u.day);
  field("hour", u.hour);
  field("minute", u.minute);
  field("second", u.second);
  field("nanoseconds", u.nanoseconds);
  field("valid", u.flags);
};

constexpr auto kGnssFields = [](auto& g, auto& field) {
  field("itow_ms", g.itow_ms);
  kUtcFields(g.utc, field);
  field("time_accuracy_ns", g.time_accuracy_ns);
  field("nano", g.nano);
  field("fix", g.fix);
  field("flags", g.flags);
  field("satellites", g.satellites);
  field("longitude_e7_deg", g.longitude_e7_deg);
  field("latitude_e7_deg", g.latitude_e7_deg);
  field("height_mm", g.height_mm);
  field("height_msl_mm", g.height_msl_mm);
  field("horizontal_accuracy_mm", g.horizontal_accuracy_mm);
  field("vertical_accuracy_mm", g.vertical_accuracy_mm);
  field("velocity_north_mmps", g.velocity_ned_mmps[0]);
  field("velocity_east_mmps", g.velocity_ned_mmps[1]);
  field("velocity_down_mmps", g.velocity_ned_mmps[2]);
  field("ground_speed_mmps", g.ground_speed_mmps);
  field("heading_of_motion_e5_deg", g.heading_of_motion_e5_deg);
  field("speed_accuracy_mmps", g.speed_accuracy_mmps);
  field("heading_accuracy_e5_deg", g.heading_accuracy_e5_deg);
  field("heading_e5_deg", g.heading_e5_deg);
  constexpr std::array<const char*, 7> kDop = {"gdop_e2", "pdop_e2", "tdop_e2", "vdop_e2",
                                               "hdop_e2", "ndop_e2", "edop_e2"};
  for (std::size_t i = 0; i < kDop.size(); ++i) field(kDop[i], g.dop_e2[i]);
};

constexpr auto kRawFields = [](auto& r, auto& field) {
  constexpr std::array<std::array<const char*, 3>, 3> kNames = {
      {{"acc_x", "acc_y", "acc_z"}, {"gyr_x", "gyr_y", "gyr_z"}, {"mag_x", "mag_y", "mag_z"}}};
  for (int i = 0; i < 3; ++i) {
    const auto at = static_cast<std::size_t>(i);
    field(kNames[0][at], r.accelerometer[i]);
    field(kNames[1][at], r.gyroscope[i]);
    field(kNames[2][at], r.magnetometer[i]);
  }
  field("temperature", r.temperature);
};

const char* name_of(decode::MtFrame frame) {
  return frame == decode::MtFrame::ned ? "NED" : frame == decode::MtFrame::nwu ? "NWU" : "ENU";
}

bool read_frame(const json& from, decode::MtFrame& frame) {
  const auto it = from.find("reference");
  if (it == from.end()) return true;
  for (const auto known : {decode::MtFrame::enu, decode::MtFrame::ned, decode::MtFrame::nwu})
    if (*it == name_of(known)) {
      frame = known;
      return true;
    }
  return false;
}

bool read_satellites(const json& from, std::vector<decode::MtSatellite>& satellites) {
  const auto it = from.find("satellites");
  if (it == from.end()) return true;
  if (!it->is_array()) return false;
  for (const json& s : *it) {
    if (!s.is_array() || s.size() != 4) return false;
    for (const json& n : s)
      if (!n.is_number_unsigned() || n.get<std::uint64_t>() > 255) return false;
    const auto byte = [&](std::size_t i) { return s[i].get<std::uint8_t>(); };
    satellites.push_back({byte(0), byte(1), byte(2), byte(3)});
  }
  return true;
}

}  // namespace

bool MtState::has_content() const {
  bool any = false;
  const auto present = [&any](const char*, const auto& value) { any = any || value.has_value(); };
  kContentFields(sample, present);
  return any || sample.utc || sample.gnss || !satellites.empty() || raw.counts ||
         raw.gyro_temperature_c;
}

MtState mt_state(decode::Bytes data, const decode::MtSample& sample, LogTime time) {
  MtState state{time, sample, {}, decode::mt_raw_readings(data)};
  // These are wayfare.Imu.
  state.sample.acceleration_mps2.reset();
  state.sample.rate_radps.reset();
  state.sample.magnetic_field_au.reset();
  if (const auto satellites = decode::mt_satellites(data))
    for (std::size_t i = 0; i < satellites->size(); ++i)
      state.satellites.push_back((*satellites)[i]);
  return state;
}

MessageSchema mt_state_schema() {
  static const std::string schema =
      schema_json("wayfare.MtState", false,
                  R"("reference":{"type":"string"},"status_word":{"type":"integer"},)"
                  R"("temperature_c":{"type":"number"},"pressure_pa":{"type":"integer"},)"
                  R"("quaternion":{"type":"array","items":{"type":"number"}},)"
                  R"("euler_deg":{"type":"array","items":{"type":"number"}},)"
                  R"("lat_lon_deg":{"type":"array","items":{"type":"number"}},)"
                  R"("altitude_ellipsoid_m":{"type":"number"},)"
                  R"("velocity_mps":{"type":"array","items":{"type":"number"}},)"
                  R"("gnss":{"type":"object"},"satellites":{"type":"array"})");
  return {"wayfare.MtState", schema};
}

std::string mt_state_json(const MtState& state, std::string_view frame) {
  std::string out = head(state.time, frame);
  out += std::string(R"(,"reference":")") + name_of(state.sample.frame) + '"';
  FieldWriter writer(out);
  kClockFields(state.sample, writer);
  kContentFields(state.sample, writer);
  add_object(out, "utc", state.sample.utc, kUtcFields);
  add_object(out, "gnss", state.sample.gnss, kGnssFields);
  add_object(out, "raw", state.raw.counts, kRawFields);
  writer("raw_temperature_c", state.raw.temperature_c);
  writer("gyro_temperature_c", state.raw.gyro_temperature_c);
  if (!state.satellites.empty()) {
    out += R"(,"satellites":[)";
    for (const decode::MtSatellite& s : state.satellites) {
      if (out.back() != '[') out += ',';
      put_list(out, std::array<unsigned, 4>{s.system, s.id, s.cn0_dbhz, s.flags});
    }
    out += ']';
  }
  return out + '}';
}

Result<MtState> parse_mt_state(std::string_view text) {
  const json message = json::parse(text, nullptr, false);
  const auto time = time_of(message);
  if (!time || !message.contains("reference")) return malformed("wayfare.MtState");
  MtState state;
  state.time = *time;
  FieldReader reader(message);
  kClockFields(state.sample, reader);
  kContentFields(state.sample, reader);
  reader("raw_temperature_c", state.raw.temperature_c);
  reader("gyro_temperature_c", state.raw.gyro_temperature_c);
  if (!reader.good() || !read_frame(message, state.sample.frame) ||
      !read_object(message, "utc", state.sample.utc, kUtcFields) ||
      !read_object(message, "gnss", state.sample.gnss, kGnssFields) ||
      !read_object(message, "raw", state.raw.counts, kRawFields) ||
      !read_satellites(message, state.satellites))
    return malformed("wayfare.MtState");
  return state;
}

}  // namespace wayfare::logger
