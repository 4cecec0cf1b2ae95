#include <algorithm>
#include <array>
#include <cstdio>
#include <memory>

#include <wayfare/decode/awinda.hpp>
#include <wayfare/decode/mt_sample.hpp>
#include <wayfare/decode/xbus.hpp>
#include <wayfare/io/text_file.hpp>

#include "tables.hpp"

namespace wayfare::examples {

namespace {

using decode::MtSample;
using decode::XbusDecoder;
using decode::XbusId;

template <class T>
void add(Csv& csv, const std::optional<T>& value) {
  value ? csv.field(*value) : csv.empty();
}
template <int N>
void add(Csv& csv, const std::optional<Eigen::Matrix<double, N, 1>>& value) {
  for (int i = 0; i < N; ++i) value ? csv.field((*value)[i]) : csv.empty();
}

std::string text_of(const decode::MtUtc& t) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%04u-%02u-%02uT%02u:%02u:%02u.%09uZ", t.year, t.month,
                t.day, t.hour, t.minute, t.second, t.nanoseconds % 1'000'000'000U);
  return text.data();
}

constexpr std::string_view kSampleNames =
    "message,bus,counter,sensor_t_s,utc,status,ax_mps2,ay_mps2,az_mps2,gx_radps,gy_radps,gz_radps,"
    "mx_au,my_au,mz_au,qw,qx,qy,qz,roll_deg,pitch_deg,yaw_deg,dvx_mps,dvy_mps,dvz_mps,dqw,dqx,dqy,"
    "dqz,free_ax_mps2,free_ay_mps2,free_az_mps2,temperature_c,pressure_pa,lat_deg,lon_deg,"
    "h_ellipsoid_m,vx_mps,vy_mps,vz_mps,ecef_x_m,ecef_y_m,ecef_z_m";

void add(Csv& csv, const MtSample& s, decode::CounterUnwrapper& clock) {
  add(csv, s.packet_counter);
  s.sample_time_fine ? csv.field(io::format_nanoseconds(100'000 * clock.at(*s.sample_time_fine)))
                     : csv.empty();
  add(csv, s.utc ? std::optional(text_of(*s.utc)) : std::nullopt);
  add(csv, s.status_word ? s.status_word : std::optional<std::uint32_t>(s.status_byte));
  add(csv, s.acceleration_mps2);
  add(csv, s.rate_radps);
  add(csv, s.magnetic_field_au);
  add(csv, s.quaternion);
  add(csv, s.euler_deg);
  add(csv, s.delta_v_mps);
  add(csv, s.delta_q);
  add(csv, s.free_acceleration_mps2);
  add(csv, s.temperature_c);
  add(csv, s.pressure_pa);
  add(csv, s.lat_lon_deg);
  add(csv, s.altitude_ellipsoid_m);
  add(csv, s.velocity_mps);
  add(csv, s.position_ecef_m);
}

Table sample_table(decode::Bytes capture, const decode::MtLegacyLayout& layout) {
  Csv csv(kSampleNames);
  decode::CounterUnwrapper clock(std::uint64_t{1} << 32);
  std::size_t index = 0, samples = 0, unknown = 0;
  const auto statistics = decode_all<XbusDecoder>(capture, [&](const decode::XbusMessage& m) {
    ++index;
    std::optional<MtSample> sample;
    if (m.id() == XbusId::mt_data2) sample = decode::mt_sample(m.data());
    if (m.id() == XbusId::mt_data) {
      if (const auto legacy = decode::mt_legacy_sample(m.data(), layout)) sample = legacy->sample;
    }
    if (!sample) {
      unknown += m.id() == XbusId::mt_data2 || m.id() == XbusId::mt_data ? 1 : 0;
      return;
    }
    ++samples;
    add(csv.row().field(index).field(m.bus()), *sample, clock);
  });
  std::string contents =
      std::to_string(index) + " messages, " + std::to_string(samples) + " with measurements";
  if (unknown != 0) contents += ", " + std::to_string(unknown) + " of unknown layout";
  return {std::move(csv).take(), statistics, contents};
}

Table awinda_table(decode::Bytes capture, double period_s) {
  Csv csv(
      "frame,t_s,tracker,frames,ax_mps2,ay_mps2,az_mps2,gx_radps,gy_radps,gz_radps,mx_au,my_au,"
      "mz_au,status");
  const auto station = std::make_unique<decode::AwindaStation<>>(period_s);
  std::size_t rows = 0;
  const auto write = [&](const decode::AwindaMotion& m) {
    ++rows;
    std::array<char, 9> name{};
    std::snprintf(name.data(), name.size(), "%08X", m.device);
    const Duration time = from_seconds(period_s) * std::int64_t{m.frame};
    csv.row()
        .field(m.frame)
        .field(io::format_nanoseconds(time.count()))
        .field(std::string_view(name.data()));
    csv.field(m.frames);
    for (const auto* v : {&m.acceleration_mps2, &m.rate_radps, &m.field_au})
      for (int i = 0; i < 3; ++i) csv.field((*v)[i]);
    csv.field(m.status);
  };
  const auto statistics = decode_all<XbusDecoder>(capture, [&](const decode::XbusMessage& m) {
    if (m.id() != XbusId::mt_data2) return;
    if (const auto snapshot = decode::awinda_snapshot(m.data())) station->add(*snapshot, write);
  });
  station->finish(write);
  return {std::move(csv).take(), statistics,
          std::to_string(rows) + " samples of " + std::to_string(station->trackers()) +
              " trackers, " + std::to_string(station->missing()) + " frames missing, " +
              std::to_string(station->late()) + " late"};
}

}  // namespace

Table xsens_table(decode::Bytes capture, const decode::MtLegacyLayout& layout) {
  bool snapshots = false;
  double period_s = 0.01;
  decode_all<XbusDecoder>(capture, [&](const decode::XbusMessage& m) {
    if (m.id() == XbusId::configuration)
      if (const auto c = decode::awinda_configuration(m.data()); c && c->period_s > 0.0)
        period_s = c->period_s;
    snapshots |= m.id() == XbusId::mt_data2 && decode::awinda_snapshot(m.data());
  });
  return snapshots ? awinda_table(capture, period_s) : sample_table(capture, layout);
}

}  // namespace wayfare::examples
