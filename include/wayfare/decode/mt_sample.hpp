#pragma once

// The content of one Xsens MTi or MTw message, and its conversion to measurements: of MTData2, and
// of its predecessor MTData, whose fields have no ids but an order given by two settings.

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <wayfare/core/contract.hpp>
#include <wayfare/core/detail/bytes.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/decode/awinda.hpp>
#include <wayfare/decode/detail/mt_values.hpp>
#include <wayfare/decode/mt_raw.hpp>
#include <wayfare/sensors/measurements.hpp>

namespace wayfare::decode {

/// The reference frame of orientations and velocities.
enum class MtFrame : std::uint8_t {
  enu = 0,  ///< east, north, up
  ned = 4,  ///< north, east, down
  nwu = 8,  ///< north, west, up
};

/// What a message contains, each quantity if the device sends it.
struct MtSample {
  std::optional<std::uint16_t> packet_counter;    ///< wraps around after 65 535
  std::optional<std::uint32_t> sample_time_fine;  ///< 0.1 ms; wraps around at 2³² or after a day
  std::optional<std::uint32_t> sample_time_coarse;        ///< s
  std::optional<std::uint64_t> sample_time_64;            ///< in the device's unit
  std::optional<std::uint32_t> frame_counter,             ///< of 32 bits
      itow_ms;                                            ///< time of the GPS week
  std::optional<MtUtc> utc;                               ///< of the sample
  std::optional<std::uint8_t> status_byte;                ///< bits as sent
  std::optional<std::uint32_t> status_word;               ///< bits as sent
  std::optional<double> temperature_c;                    ///< of the device
  std::optional<std::uint32_t> pressure_pa;               ///< of the air
  std::optional<Eigen::Vector3d> acceleration_mps2;       ///< specific force, +g upward at rest
  std::optional<Eigen::Vector3d> free_acceleration_mps2;  ///< without gravity, in `frame`
  std::optional<Eigen::Vector3d> delta_v_mps,  ///< velocity increment of the sampling period
      rate_radps;                              ///< angular rate
  std::optional<Eigen::Vector3d> acceleration_hr_mps2,  ///< at the sensor's own rate
      rate_hr_radps;                                    ///< the same of the angular rate
  std::optional<Eigen::Vector3d>
      magnetic_field_au;                     ///< in units of the Earth's field where calibrated
  std::optional<Eigen::Vector4d> delta_q,    ///< rotation of the sampling period, w, x, y, z
      quaternion;                            ///< w, x, y, z; sensor to `frame`
  std::optional<Eigen::Vector3d> euler_deg;  ///< roll, pitch, yaw
  std::optional<Eigen::Matrix3d> rotation_matrix;  ///< sensor to `frame`
  std::optional<Eigen::Vector2d> lat_lon_deg;      ///< of the receiver
  std::optional<double> altitude_msl_m,            ///< above mean sea level
      altitude_ellipsoid_m;                        ///< above WGS-84
  std::optional<Eigen::Vector3d> velocity_mps,     ///< in `frame`
      position_ecef_m;                             ///< WGS-84
  std::optional<MtGnss> gnss;                      ///< of the receiver
  std::optional<std::int8_t> rssi_dbm;             ///< signal strength of a wireless tracker
  MtFrame frame = MtFrame::enu;                    ///< of the orientation, acceleration or velocity
  /// Packets of another id or of a wrong length. Those of `mt_raw.hpp` are not among them.
  std::uint16_t unknown = 0;
};

namespace detail {

// Store the content of a packet; false where it has another length.

/// A matrix is sent column by column.
template <int Rows, int Columns>
bool take(const MtPacket& p, std::optional<Eigen::Matrix<double, Rows, Columns>>& to) {
  const auto values = p.reals<std::size_t{Rows} * std::size_t{Columns}>();
  if (values) to = Eigen::Map<const Eigen::Matrix<double, Rows, Columns>>(values->data());
  return values.has_value();
}
inline bool take(const MtPacket& p, std::optional<double>& to) {
  const auto values = p.reals<1>();
  if (values) to = values->front();
  return values.has_value();
}
template <std::integral T>
bool take(const MtPacket& p, std::optional<T>& to) {
  const auto value = p.whole<T>();
  if (value) to = value;
  return value.has_value();
}

/// Stores one packet; false where its id is unknown or its length wrong.
inline bool take_packet(const MtPacket& p, MtSample& s) {
  const std::uint16_t kind = p.kind();
  if (kind == 0x0810) return take(p, s.temperature_c);
  if (kind == 0x1010 && p.data.size() == 12) s.utc = mt_utc(p.data.data());
  if (kind == 0x1010) return p.data.size() == 12;
  if (kind == 0x1020) return take(p, s.packet_counter);
  if (kind == 0x1060) return take(p, s.sample_time_fine);
  if (kind == 0x1070) return take(p, s.sample_time_coarse);
  if (kind == 0x2010) return take(p, s.quaternion);
  if (kind == 0x2020) return take(p, s.rotation_matrix);
  if (kind == 0x2030) return take(p, s.euler_deg);
  if (kind == 0x3010) return take(p, s.pressure_pa);
  if (kind == 0x4010) return take(p, s.delta_v_mps);
  if (kind == 0x4020) return take(p, s.acceleration_mps2);
  if (kind == 0x4030) return take(p, s.free_acceleration_mps2);
  if (kind == 0x4040) return take(p, s.acceleration_hr_mps2);
  if (kind == 0x5010) return take(p, s.altitude_msl_m);
  if (kind == 0x5020) return take(p, s.altitude_ellipsoid_m);
  if (kind == 0x5030) return take(p, s.position_ecef_m);
  if (kind == 0x5040) return take(p, s.lat_lon_deg);
  if (kind == 0x7010) return (s.gnss = mt_gnss(p.data)).has_value();
  if (kind == 0x8020) return take(p, s.rate_radps);
  if (kind == 0x8030) return take(p, s.delta_q);
  if (kind == 0x8040) return take(p, s.rate_hr_radps);
  if (kind == 0xC020) return take(p, s.magnetic_field_au);
  if (kind == 0xD010) return take(p, s.velocity_mps);
  if (kind == 0xE010) return take(p, s.status_byte);
  if (kind == 0xE020) return take(p, s.status_word);
  if (kind == 0xE040) return take(p, s.rssi_dbm);
  if (kind == 0x1030) return take(p, s.itow_ms);
  if (kind == 0x10A0) return take(p, s.sample_time_64);
  if (kind == 0x10B0) return take(p, s.frame_counter);
  return is_raw_packet(kind, p.data.size());
}

[[nodiscard]] inline bool has_frame(std::uint16_t kind) {
  return kind >> 8 == 0x20 || kind == 0x4030 || kind == 0xD010;
}

}  // namespace detail

/// The content of an MTData2 message; nullopt where its packets exceed its length.
[[nodiscard]] inline std::optional<MtSample> mt_sample(Bytes data) {
  MtSample sample;
  const bool whole = for_each_mt_packet(data, [&](const MtPacket& packet) {
    if (!detail::take_packet(packet, sample)) ++sample.unknown;
    if (detail::has_frame(packet.kind())) sample.frame = static_cast<MtFrame>(packet.id & 0xC);
  });
  return whole ? std::optional(sample) : std::nullopt;
}

/// Rate and acceleration; nullopt where either is missing.
[[nodiscard]] inline std::optional<ImuSample> to_imu_sample(const MtSample& sample, LogTime time) {
  if (!sample.rate_radps || !sample.acceleration_mps2) return std::nullopt;
  return ImuSample{time, *sample.rate_radps, *sample.acceleration_mps2};
}

/// The available measurements. `earth_field_uT` is the strength of the Earth's field where the
/// device's magnetometer was calibrated, the unit of its readings.
[[nodiscard]] inline MargSample to_marg_sample(const MtSample& sample, LogTime time,
                                               double earth_field_uT = 49.0) {
  MargSample marg;
  marg.time = time;
  if (sample.rate_radps) marg.angular_rate_radps = *sample.rate_radps;
  if (sample.acceleration_mps2) marg.specific_force_mps2 = *sample.acceleration_mps2;
  if (sample.magnetic_field_au) marg.magnetic_field_uT = earth_field_uT * *sample.magnetic_field_au;
  return marg;
}

/// A tracker's motion as a nine-axis sample.
[[nodiscard]] inline MargSample to_marg_sample(const AwindaMotion& motion, LogTime time,
                                               double earth_field_uT = 49.0) {
  return {time, motion.rate_radps, motion.acceleration_mps2, earth_field_uT * motion.field_au};
}

/// Unwraps a counter: SampleTimeFine at 2³² or at 864 000 000, PacketCounter at 65 536, frames at
/// 2³². Steps back by less than half the period remain steps back.
class CounterUnwrapper {
 public:
  /// `period` from 1 to 2³².
  explicit CounterUnwrapper(std::uint64_t period) : period_(static_cast<std::int64_t>(period)) {
    WAYFARE_EXPECTS(period >= 1 && period <= std::uint64_t{1} << 32, "no period of a counter");
  }

  /// The counter continued beyond its period, from the first count on.
  [[nodiscard]] std::int64_t at(std::uint32_t count) {
    std::int64_t step = (static_cast<std::int64_t>(count) - total_) % period_;
    if (step < 0) step += period_;
    if (started_ && step > period_ / 2) step -= period_;
    started_ = true;
    return total_ += step;
  }

 private:
  std::int64_t period_, total_ = 0;
  bool started_ = false;
};

/// The device's SetOutputMode and SetOutputSettings.
struct MtLegacyLayout {
  std::uint16_t mode = 0;      ///< SetOutputMode: which parts a message has
  std::uint32_t settings = 0;  ///< SetOutputSettings: their forms

  /// Number format, bits 8 and 9 of the settings.
  [[nodiscard]] MtPrecision precision() const {
    return static_cast<MtPrecision>(settings >> 8 & 3);
  }
};

/// A legacy message: the calibrated parts in the same form as of MTData2.
struct MtLegacySample {
  MtSample sample;                              ///< calibrated parts
  std::optional<MtRaw> raw;                     ///< if the layout has them
  std::optional<std::uint16_t> aux1,            ///< analogue inputs, counts
      aux2;                                     ///< counts
  std::optional<Eigen::Vector3d> position_lla;  ///< degrees, degrees, m
};

namespace detail {

/// Reads from the front; once anything is missing, every later read fails.
class MtCursor {
 public:
  MtCursor(Bytes data, MtPrecision precision) : data_(data), precision_(precision) {}

  [[nodiscard]] bool at_end() const { return good_ && data_.empty(); }

  Bytes next(std::size_t n) {
    good_ = good_ && n <= data_.size();
    if (!good_) return {};
    const Bytes taken = data_.first(n);
    data_ = data_.subspan(n);
    return taken;
  }
  template <class T>
  T whole() {
    const Bytes b = next(sizeof(T));
    return b.empty() ? T{} : load_be<T>(b.data());
  }
  template <int N>
  Eigen::Matrix<double, N, 1> reals() {
    Eigen::Matrix<double, N, 1> values = Eigen::Matrix<double, N, 1>::Zero();
    const std::size_t size = bytes_of(precision_);
    const Bytes b = next(N * size);
    if (b.empty()) return values;
    for (int i = 0; i < N; ++i)
      values[i] = mt_real(&b[static_cast<std::size_t>(i) * size], precision_);
    good_ = values.allFinite();
    return values;
  }

 private:
  Bytes data_;
  MtPrecision precision_;
  bool good_ = true;
};

inline void take_raw(MtCursor& in, MtLegacySample& out) {
  MtRaw raw;
  for (auto* vector : {&raw.accelerometer, &raw.gyroscope, &raw.magnetometer})
    for (int i = 0; i < 3; ++i) (*vector)[i] = in.whole<std::uint16_t>();
  raw.temperature = in.whole<std::uint16_t>();
  out.raw = raw;
}

inline void take_orientation(MtCursor& in, std::uint32_t settings, MtSample& out) {
  if ((settings & 0xC) == 0x0) {
    out.quaternion = in.reals<4>();
  } else if ((settings & 0xC) == 0x4) {
    out.euler_deg = in.reals<3>();
  } else {
    const Eigen::Matrix<double, 9, 1> columns = in.reals<9>();
    out.rotation_matrix = Eigen::Map<const Eigen::Matrix3d>(columns.data());
  }
}

}  // namespace detail

/// The content of an MTData message of this layout; nullopt where its length does not match the
/// layout, or where the layout includes a receiver's raw data (mode 1000), which is not supported.
[[nodiscard]] inline std::optional<MtLegacySample> mt_legacy_sample(Bytes data,
                                                                    const MtLegacyLayout& layout) {
  const std::uint16_t mode = layout.mode;
  const std::uint32_t settings = layout.settings;
  if ((mode & 0x1000) != 0) return std::nullopt;
  detail::MtCursor in(data, layout.precision());
  MtLegacySample out;
  MtSample& s = out.sample;
  s.frame = (settings & 0x80000000U) != 0 ? MtFrame::ned : MtFrame::nwu;
  if ((mode & 0x4000) != 0) detail::take_raw(in, out);
  if ((mode & 0x0001) != 0) s.temperature_c = in.reals<1>()[0];
  if ((mode & 0x0002) != 0) {
    if ((settings & 0x10) == 0) s.acceleration_mps2 = in.reals<3>();
    if ((settings & 0x20) == 0) s.rate_radps = in.reals<3>();
    if ((settings & 0x40) == 0) s.magnetic_field_au = in.reals<3>();
  }
  if ((mode & 0x0004) != 0) detail::take_orientation(in, settings, s);
  if ((mode & 0x0008) != 0) {
    if ((settings & 0x400) == 0) out.aux1 = in.whole<std::uint16_t>();
    if ((settings & 0x800) == 0) out.aux2 = in.whole<std::uint16_t>();
  }
  if ((mode & 0x0010) != 0) out.position_lla = in.reals<3>();
  if ((mode & 0x0020) != 0) s.velocity_mps = in.reals<3>();
  if ((mode & 0x0800) != 0) s.status_byte = in.whole<std::uint8_t>();
  if ((settings & 1) != 0) s.packet_counter = in.whole<std::uint16_t>();
  if ((settings & 2) != 0) {
    const Bytes utc = in.next(12);
    if (!utc.empty()) s.utc = detail::mt_utc(utc.data());
  }
  return in.at_end() ? std::optional(out) : std::nullopt;
}

}  // namespace wayfare::decode
