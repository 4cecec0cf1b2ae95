#pragma once

// What an MTData2 message has besides measurements: uncalibrated readings, satellites, snapshots of
// body straps and gloves. Layouts: Xsens, MT Low Level Communication Protocol, and datapacket_p.h
// of xspublic for the snapshots, whose scales are not published. No capture of these packets except
// of the satellites is at hand: they are tested against encoders of the layouts.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include <Eigen/Core>

#include <wayfare/core/detail/bytes.hpp>
#include <wayfare/core/detail/eigen_alignment.hpp>
#include <wayfare/decode/detail/mt_values.hpp>

namespace wayfare::decode {

/// Raw readings of the converters, uncalibrated.
struct MtRaw {
  Eigen::Matrix<std::uint16_t, 3, 1> accelerometer,  ///< counts
      gyroscope,                                     ///< counts
      magnetometer;                                  ///< counts
  std::uint16_t temperature = 0;                     ///< counts
};

/// Uncalibrated readings of an MTData2 message (A010, A020).
struct MtRawReadings {
  std::optional<MtRaw> counts;                        ///< of the converters
  std::optional<double> temperature_c;                ///< of the device, with `counts`
  std::optional<Eigen::Vector3d> gyro_temperature_c;  ///< of each gyroscope
};

/// A satellite as the receiver of a device reports it.
struct MtSatellite {
  std::uint8_t system = 0,  ///< 0 GPS, 1 SBAS, 2 Galileo, 3 BeiDou, 5 QZSS, 6 GLONASS
      id = 0,               ///< number in its system
      cn0_dbhz = 0,         ///< carrier to noise density ratio
      flags = 0;            ///< bits 0 to 2 quality, 3 used, 4, 5 health, 6, 7 corrections
};

/// The satellites in view (7020). Refers to the message's bytes.
class MtSatellites {
 public:
  /// `data` of a packet of 8 + 4 n bytes, n in the fifth.
  explicit MtSatellites(Bytes data) : data_(data) {}

  /// Time of the GPS week, ms.
  [[nodiscard]] std::uint32_t itow_ms() const { return load_be<std::uint32_t>(data_.data()); }
  [[nodiscard]] std::size_t size() const { return data_[4]; }  ///< number of satellites
  /// Satellite i < size().
  [[nodiscard]] MtSatellite operator[](std::size_t i) const {
    const std::uint8_t* p = &data_[8 + 4 * i];
    return {p[0], p[1], p[2], p[3]};
  }

 private:
  Bytes data_;
};

/// The integrals of a strapdown integrator at the end of a frame (C820), in the units of the
/// message.
struct MtFullSnapshot {
  std::uint16_t frame = 0;                    ///< counter
  std::uint64_t timestamp = 0;                ///< of the device
  std::array<std::int32_t, 4> orientation{};  ///< integrated
  std::array<std::int64_t, 3> velocity{};     ///< integrated
  std::array<std::int32_t, 3> field{};        ///< magnetic
  std::int32_t pressure = 0;                  ///< of the air
  std::uint8_t clipped_acceleration = 0,      ///< counter
      clipped_rate = 0;                       ///< counter
  std::uint16_t status = 0;                   ///< bits as of an Awinda snapshot
};

/// The integrals of one segment of a glove, in the units of the message.
struct MtFinger {
  std::array<std::int32_t, 3> orientation{};  ///< integrated, 24 bits with sign
  std::array<std::int32_t, 3> velocity{};     ///< integrated
  std::array<std::int16_t, 3> field{};        ///< magnetic
  std::uint16_t flags = 0;                    ///< as sent
  std::uint8_t clipped_acceleration = 0,      ///< counter
      clipped_rate = 0;                       ///< counter
};

/// A glove's snapshot (C830 left, C840 right).
struct MtGlove {
  bool right = false;                  ///< hand
  std::uint32_t frame = 0;             ///< counter
  std::uint16_t valid = 0;             ///< a bit for each segment
  std::array<MtFinger, 12> fingers{};  ///< segments of the hand
};

namespace detail {

inline constexpr std::size_t kGloveHead = 7, kFinger = 31, kGlove = kGloveHead + 12 * kFinger;

/// Whether a packet of this id and length is one that the functions below read.
[[nodiscard]] constexpr bool is_raw_packet(std::uint16_t kind, std::size_t bytes) {
  switch (kind) {
    case 0xA010:
      return bytes == 20;
    case 0xA020:
      return bytes == 6;
    case 0x7020:
      return bytes >= 8 && bytes % 4 == 0;
    case 0xC820:
      return bytes == 70;
    case 0xC830:
    case 0xC840:
      return bytes == 255 || bytes == kGlove - 255;
    default:
      return false;
  }
}

/// Calls `f` with the packets of `kind` that have a known length.
template <class F>
void for_each_raw_packet(Bytes data, std::uint16_t kind, F&& f) {
  static_cast<void>(for_each_mt_packet(data, [&](const MtPacket& p) {
    if (p.kind() == kind && is_raw_packet(kind, p.data.size())) f(p.data);
  }));
}

[[nodiscard]] inline MtFinger mt_finger(const std::uint8_t* p) {
  MtFinger f;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::uint32_t high = load_be<std::uint16_t>(p + 3 * i);
    f.orientation[i] =
        static_cast<std::int32_t>(high << 16 | std::uint32_t{p[3 * i + 2]} << 8) >> 8;
    f.velocity[i] = load_be<std::int32_t>(p + 9 + 4 * i);
    f.field[i] = load_be<std::int16_t>(p + 21 + 2 * i);
  }
  f.flags = load_be<std::uint16_t>(p + 27);
  f.clipped_acceleration = p[29];
  f.clipped_rate = p[30];
  return f;
}

}  // namespace detail

/// The uncalibrated readings in an MTData2 message.
[[nodiscard]] inline MtRawReadings mt_raw_readings(Bytes data) {
  MtRawReadings readings;
  const auto celsius = [](const std::uint8_t* p) { return load_be<std::int16_t>(p) / 256.0; };
  detail::for_each_raw_packet(data, 0xA010, [&](Bytes b) {
    MtRaw raw;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto axis = static_cast<Eigen::Index>(i);
      raw.accelerometer[axis] = load_be<std::uint16_t>(&b[2 * i]);
      raw.gyroscope[axis] = load_be<std::uint16_t>(&b[6 + 2 * i]);
      raw.magnetometer[axis] = load_be<std::uint16_t>(&b[12 + 2 * i]);
    }
    raw.temperature = load_be<std::uint16_t>(&b[18]);
    readings.counts = raw;
    readings.temperature_c = celsius(&b[18]);
  });
  detail::for_each_raw_packet(data, 0xA020, [&](Bytes b) {
    readings.gyro_temperature_c = Eigen::Vector3d(celsius(&b[0]), celsius(&b[2]), celsius(&b[4]));
  });
  return readings;
}

/// The satellites in an MTData2 message; nullopt without them or where their number is not that of
/// the bytes.
[[nodiscard]] inline std::optional<MtSatellites> mt_satellites(Bytes data) {
  std::optional<MtSatellites> found;
  detail::for_each_raw_packet(data, 0x7020, [&](Bytes b) {
    if (b.size() == 8 + 4 * std::size_t{b[4]}) found = MtSatellites(b);
  });
  return found;
}

/// The full snapshot in an MTData2 message.
[[nodiscard]] inline std::optional<MtFullSnapshot> mt_full_snapshot(Bytes data) {
  std::optional<MtFullSnapshot> found;
  detail::for_each_raw_packet(data, 0xC820, [&](Bytes b) {
    MtFullSnapshot s;
    s.frame = load_be<std::uint16_t>(&b[0]);
    s.timestamp = load_be<std::uint64_t>(&b[2]);
    for (std::size_t i = 0; i < 4; ++i) s.orientation[i] = load_be<std::int32_t>(&b[10 + 4 * i]);
    for (std::size_t i = 0; i < 3; ++i) {
      s.velocity[i] = load_be<std::int64_t>(&b[26 + 8 * i]);
      s.field[i] = load_be<std::int32_t>(&b[50 + 4 * i]);
    }
    s.pressure = load_be<std::int32_t>(&b[62]);
    s.clipped_acceleration = b[66];
    s.clipped_rate = b[67];
    s.status = load_be<std::uint16_t>(&b[68]);
    found = s;
  });
  return found;
}

/// The glove in an MTData2 message: two packets of the same id, since one has 255 bytes at most.
[[nodiscard]] inline std::optional<MtGlove> mt_glove(Bytes data, bool right) {
  std::array<std::uint8_t, detail::kGlove> all{};
  std::size_t held = 0;
  detail::for_each_raw_packet(data, right ? 0xC840 : 0xC830, [&](Bytes b) {
    if (b.size() != (held == 0 ? 255 : detail::kGlove - 255) || held == detail::kGlove) return;
    std::copy(b.begin(), b.end(), all.begin() + static_cast<std::ptrdiff_t>(held));
    held += b.size();
  });
  if (held != detail::kGlove) return std::nullopt;
  MtGlove glove;
  glove.right = right;
  glove.frame = load_be<std::uint32_t>(&all[0]);
  glove.valid = load_be<std::uint16_t>(&all[4]);
  for (std::size_t i = 0; i < 12; ++i)
    glove.fingers[i] = detail::mt_finger(&all[detail::kGloveHead + detail::kFinger * i]);
  return glove;
}

}  // namespace wayfare::decode
