#pragma once

// The packets inside an Xsens MTData2 message, the four encodings of their numbers, and a GNSS
// receiver's solution.

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>

#include <wayfare/core/detail/bytes.hpp>

namespace wayfare::decode {

/// Encoding of numbers: the lowest two bits of a packet's id.
enum class MtPrecision : std::uint8_t {
  float32 = 0,      ///< IEEE 754, four bytes
  fixed_12_20 = 1,  ///< twelve bits before the point
  fixed_16_32 = 2,  ///< sixteen bits before the point
  float64 = 3       ///< IEEE 754, eight bytes
};

/// Of one number.
[[nodiscard]] constexpr std::size_t bytes_of(MtPrecision precision) {
  constexpr std::array<std::size_t, 4> kBytes = {4, 4, 6, 8};
  return kBytes[static_cast<std::size_t>(precision)];
}

/// One number. The 48 bits of 16.32 are the fraction, then the whole part.
[[nodiscard]] inline double mt_real(const std::uint8_t* p, MtPrecision precision) {
  switch (precision) {
    case MtPrecision::float32:
      return static_cast<double>(load_be<float>(p));
    case MtPrecision::fixed_12_20:
      return load_be<std::int32_t>(p) * 0x1p-20;
    case MtPrecision::fixed_16_32:
      return load_be<std::int16_t>(p + 4) + load_be<std::uint32_t>(p) * 0x1p-32;
    default:
      return load_be<double>(p);
  }
}

/// A packet: id and data.
struct MtPacket {
  std::uint16_t id = 0;  ///< of the content, with precision and frame in its lowest bits
  Bytes data;            ///< numbers, big endian

  /// The id without precision and frame.
  [[nodiscard]] std::uint16_t kind() const { return static_cast<std::uint16_t>(id & 0xFFF0); }
  /// Of the numbers.
  [[nodiscard]] MtPrecision precision() const { return static_cast<MtPrecision>(id & 3); }

  /// `N` numbers; nullopt where the packet has a different length or one is not finite.
  template <std::size_t N>
  [[nodiscard]] std::optional<std::array<double, N>> reals() const {
    const std::size_t size = bytes_of(precision());
    if (data.size() != N * size) return std::nullopt;
    std::array<double, N> values{};
    for (std::size_t i = 0; i < N; ++i) {
      values[i] = mt_real(&data[i * size], precision());
      if (!std::isfinite(values[i])) return std::nullopt;
    }
    return values;
  }
  /// A whole number that is the packet's only content.
  template <class T>
  [[nodiscard]] std::optional<T> whole() const {
    if (data.size() != sizeof(T)) return std::nullopt;
    return load_be<T>(data.data());
  }
};

/// Calls `f(const MtPacket&)` for the packets of an MTData2 message in order; false where the last
/// one is longer than the message.
template <class F>
bool for_each_mt_packet(Bytes data, F&& f) {
  while (!data.empty()) {
    if (data.size() < 3 || data.size() - 3 < data[2]) return false;
    f(MtPacket{load_be<std::uint16_t>(data.data()), data.subspan(3, data[2])});
    data = data.subspan(3U + data[2]);
  }
  return true;
}

/// Universal time, with flags of what is valid.
struct MtUtc {
  std::uint32_t nanoseconds = 0;  ///< of the second
  std::uint16_t year = 0;         ///< AD
  std::uint8_t month = 0,         ///< 1 to 12
      day = 0,                    ///< from 1
      hour = 0,                   ///< 0 to 23
      minute = 0,                 ///< 0 to 59
      second = 0;                 ///< 0 to 60
  std::uint8_t flags = 0;         ///< bit 0 date, 1 time of day, 2 leap seconds are valid

  bool operator==(const MtUtc&) const = default;  ///< all fields
};

/// A GNSS receiver's solution, in the units of the message.
struct MtGnss {
  std::uint32_t itow_ms = 0;                        ///< GPS time of week
  MtUtc utc;                                        ///< nanoseconds may be negative: see `nano`
  std::uint32_t time_accuracy_ns = 0;               ///< estimate
  std::int32_t nano = 0;                            ///< fraction of the second, may be negative, ns
  std::uint8_t fix = 0,                             ///< kind of fix
      flags = 0,                                    ///< as u-blox sends them
      satellites = 0;                               ///< number used
  std::int32_t longitude_e7_deg = 0,                ///< 1e-7°
      latitude_e7_deg = 0,                          ///< 1e-7°
      height_mm = 0,                                ///< above the ellipsoid
      height_msl_mm = 0;                            ///< above mean sea level
  std::uint32_t horizontal_accuracy_mm = 0,         ///< estimate
      vertical_accuracy_mm = 0;                     ///< estimate
  std::array<std::int32_t, 3> velocity_ned_mmps{};  ///< north, east, down
  std::int32_t ground_speed_mmps = 0,               ///< over ground
      heading_of_motion_e5_deg = 0;                 ///< course, 1e-5°
  std::uint32_t speed_accuracy_mmps = 0,            ///< estimate
      heading_accuracy_e5_deg = 0;                  ///< estimate, 1e-5°
  std::int32_t heading_e5_deg = 0;                  ///< of the vehicle, 1e-5°
  /// Dilution of precision in hundredths: geometric, position, time, vertical, horizontal, north,
  /// east.
  std::array<std::uint16_t, 7> dop_e2{};
};

namespace detail {

[[nodiscard]] inline MtUtc mt_utc(const std::uint8_t* p) {
  return {load_be<std::uint32_t>(p),
          load_be<std::uint16_t>(p + 4),
          p[6],
          p[7],
          p[8],
          p[9],
          p[10],
          p[11]};
}

[[nodiscard]] inline std::optional<MtGnss> mt_gnss(Bytes b) {
  if (b.size() != 94) return std::nullopt;
  const auto i32 = [&](std::size_t at) { return load_be<std::int32_t>(&b[at]); };
  const auto u32 = [&](std::size_t at) { return load_be<std::uint32_t>(&b[at]); };
  MtGnss g;
  g.itow_ms = u32(0);
  g.utc = {0, load_be<std::uint16_t>(&b[4]), b[6], b[7], b[8], b[9], b[10], b[11]};
  g.time_accuracy_ns = u32(12);
  g.nano = i32(16);
  g.fix = b[20];
  g.flags = b[21];
  g.satellites = b[22];
  g.longitude_e7_deg = i32(24);
  g.latitude_e7_deg = i32(28);
  g.height_mm = i32(32);
  g.height_msl_mm = i32(36);
  g.horizontal_accuracy_mm = u32(40);
  g.vertical_accuracy_mm = u32(44);
  g.velocity_ned_mmps = {i32(48), i32(52), i32(56)};
  g.ground_speed_mmps = i32(60);
  g.heading_of_motion_e5_deg = i32(64);
  g.speed_accuracy_mmps = u32(68);
  g.heading_accuracy_e5_deg = u32(72);
  g.heading_e5_deg = i32(76);
  for (std::size_t i = 0; i < 7; ++i) g.dop_e2[i] = load_be<std::uint16_t>(&b[80 + 2 * i]);
  return g;
}

}  // namespace detail

}  // namespace wayfare::decode
