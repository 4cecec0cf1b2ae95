#pragma once

// Contents of messages of u-blox receivers (u-blox, F9 HPG 1.32 Interface Description,
// UBX-22008968).
//
//   decoder.feed(bytes, [](const UbxMessage& m) {
//     if (const auto raw = rxm_rawx(m)) use(raw->epoch(), raw->measurement(0));
//   });

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>

#include <wayfare/core/detail/bytes.hpp>
#include <wayfare/decode/ubx.hpp>

namespace wayfare::decode {

/// Satellite systems as the receiver numbers them.
enum class UbxGnss : std::uint8_t {
  gps = 0,      ///< USA
  sbas = 1,     ///< augmentation, geostationary
  galileo = 2,  ///< Europe
  beidou = 3,   ///< China
  qzss = 5,     ///< Japan
  glonass = 6,  ///< Russia
  navic = 7,    ///< India
};

/// Time of a RXM-RAWX message, by the receiver's clock.
struct UbxRawxEpoch {
  double time_of_week_s = 0.0;      ///< GPS time
  int week = 0;                     ///< GPS week
  int leap_seconds = 0;             ///< GPS − UTC
  bool leap_seconds_known = false;  ///< else the firmware's default
  bool clock_reset = false;         ///< the receiver's clock was set since the last message
};

/// A satellite's signal in a RXM-RAWX message. Standard deviations are the receiver's estimates.
struct UbxMeasurement {
  double pseudorange_m = 0.0;               ///< biased by the receiver's clock
  double carrier_phase_cycles = 0.0;        ///< with an unknown whole number
  float doppler_hz = 0.0F;                  ///< positive for an approaching satellite
  UbxGnss gnss = UbxGnss::gps;              ///< the satellite's system
  int satellite = 0;                        ///< its number
  int signal = 0;                           ///< sigId of table 1.5.4 there
  int glonass_channel = 0;                  ///< −7 to 6, of GLONASS
  double lock_time_s = 0.0;                 ///< of the carrier loop, at most 64.5 s
  int cn0_db_hz = 0;                        ///< carrier to noise density
  double pseudorange_sigma_m = 0.0;         ///< 0.01 m times a power of two
  double carrier_phase_sigma_cycles = 0.0;  ///< infinite: not known
  double doppler_sigma_hz = 0.0;            ///< 0.002 Hz times a power of two
  bool pseudorange_valid = false;           ///< else it is not to be used
  bool carrier_phase_valid = false;         ///< else it is not to be used
  bool half_cycle_resolved = false;         ///< else the phase may be off by half a cycle
  bool half_cycle_subtracted = false;       ///< from the phase
};

/// RXM-RAWX: ranges, Doppler shifts and carrier phases of one epoch.
class UbxRawx {
 public:
  /// Of a message whose length fits; see rxm_rawx().
  explicit UbxRawx(Bytes payload) : payload_(payload) {}

  /// Its time.
  [[nodiscard]] UbxRawxEpoch epoch() const {
    const std::uint8_t status = payload_[12];
    return {load_le<double>(&payload_[0]), load_le<std::uint16_t>(&payload_[8]),
            load_le<std::int8_t>(&payload_[10]), (status & 1U) != 0, (status & 2U) != 0};
  }
  /// Number of measurements.
  [[nodiscard]] std::size_t size() const { return payload_[11]; }
  /// Measurement `i` of size().
  [[nodiscard]] UbxMeasurement measurement(std::size_t i) const {
    const std::uint8_t* p = &payload_[16 + 32 * i];
    UbxMeasurement m;
    m.pseudorange_m = load_le<double>(p);
    m.carrier_phase_cycles = load_le<double>(p + 8);
    m.doppler_hz = load_le<float>(p + 16);
    m.gnss = static_cast<UbxGnss>(p[20]);
    m.satellite = p[21];
    m.signal = p[22];
    m.glonass_channel = m.gnss == UbxGnss::glonass ? p[23] - 7 : 0;
    m.lock_time_s = 1e-3 * load_le<std::uint16_t>(p + 24);
    m.cn0_db_hz = p[26];
    m.pseudorange_sigma_m = std::ldexp(0.01, p[27] & 0x0F);
    const int phase = p[28] & 0x0F;
    m.carrier_phase_sigma_cycles =
        phase == 0x0F ? std::numeric_limits<double>::infinity() : 0.004 * phase;
    m.doppler_sigma_hz = std::ldexp(0.002, p[29] & 0x0F);
    m.pseudorange_valid = (p[30] & 1U) != 0;
    m.carrier_phase_valid = (p[30] & 2U) != 0;
    m.half_cycle_resolved = (p[30] & 4U) != 0;
    m.half_cycle_subtracted = (p[30] & 8U) != 0;
    return m;
  }

 private:
  Bytes payload_;
};

/// RXM-SFRBX: a subframe or page of a satellite's navigation message.
class UbxSubframe {
 public:
  /// Of a message whose length fits; see rxm_sfrbx().
  explicit UbxSubframe(Bytes payload) : payload_(payload) {}

  /// The satellite's system.
  [[nodiscard]] UbxGnss gnss() const { return static_cast<UbxGnss>(payload_[0]); }
  [[nodiscard]] int satellite() const { return payload_[1]; }  ///< its number
  [[nodiscard]] int signal() const { return payload_[2]; }     ///< sigId, 0 in old firmware
  /// −7 to 6, of GLONASS.
  [[nodiscard]] int glonass_channel() const {
    return gnss() == UbxGnss::glonass ? payload_[3] - 7 : 0;
  }
  /// Number of words.
  [[nodiscard]] std::size_t size() const { return payload_[4]; }
  /// Word `i` as it was received, parity included.
  [[nodiscard]] std::uint32_t word(std::size_t i) const {
    return load_le<std::uint32_t>(&payload_[8 + 4 * i]);
  }

 private:
  Bytes payload_;
};

/// NAV-PVT: the receiver's own position, velocity and time. Standard deviations are its estimates.
struct UbxPvt {
  double time_of_week_s = 0.0;  ///< GPS time, rounded to 1 ms
  /// @{
  /// UTC.
  int year = 0, month = 0, day = 0, hour = 0, minute = 0, second = 0;
  /// @}
  std::int32_t nanosecond = 0;      ///< of the second, may be negative
  bool date_valid = false;          ///< year, month, day
  bool time_valid = false;          ///< time of day
  bool time_resolved = false;       ///< to the second
  double time_sigma_s = 0.0;        ///< of the time
  int fix_type = 0;                 ///< 0 none, 1 dead reckoning, 2 2D, 3 3D, 4 both, 5 time only
  bool fix_ok = false;              ///< within the receiver's limits of accuracy
  bool differential = false;        ///< corrections were used
  int carrier_solution = 0;         ///< 0 none, 1 float, 2 fixed ambiguities
  int satellites = 0;               ///< used
  double longitude_deg = 0.0;       ///< east positive
  double latitude_deg = 0.0;        ///< north positive
  double height_m = 0.0;            ///< above the ellipsoid
  double height_above_sea_m = 0.0;  ///< above mean sea level
  double horizontal_sigma_m = 0.0;  ///< of the position
  double vertical_sigma_m = 0.0;    ///< of the height
  std::array<double, 3> velocity_ned_mps = {};  ///< north, east, down
  double ground_speed_mps = 0.0;                ///< horizontal
  double course_deg = 0.0;                      ///< of the motion, clockwise from north
  double speed_sigma_mps = 0.0;                 ///< of the speed
  double course_sigma_deg = 0.0;                ///< of the course
  double pdop = 0.0;                            ///< dilution of precision, position
};

/// Nullopt for another message, or one whose length does not fit its number of measurements.
[[nodiscard]] inline std::optional<UbxRawx> rxm_rawx(const UbxMessage& m) {
  const Bytes p = m.payload();
  if (m.id() != UbxId::rxm_rawx || p.size() < 16 || p.size() != 16 + 32 * std::size_t{p[11]})
    return std::nullopt;
  return UbxRawx(p);
}

/// Nullopt for another message, or one whose length does not fit its number of words.
[[nodiscard]] inline std::optional<UbxSubframe> rxm_sfrbx(const UbxMessage& m) {
  const Bytes p = m.payload();
  if (m.id() != UbxId::rxm_sfrbx || p.size() < 8 || p.size() != 8 + 4 * std::size_t{p[4]})
    return std::nullopt;
  return UbxSubframe(p);
}

/// Nullopt for another message, or one that is not 92 bytes long.
[[nodiscard]] inline std::optional<UbxPvt> nav_pvt(const UbxMessage& m) {
  const Bytes b = m.payload();
  if (m.id() != UbxId::nav_pvt || b.size() != 92) return std::nullopt;
  const std::uint8_t* p = b.data();
  const auto mm = [p](std::size_t at) { return 1e-3 * load_le<std::int32_t>(p + at); };
  const auto unsigned_mm = [p](std::size_t at) { return 1e-3 * load_le<std::uint32_t>(p + at); };
  UbxPvt v;
  v.time_of_week_s = 1e-3 * load_le<std::uint32_t>(p);
  v.year = load_le<std::uint16_t>(p + 4);
  v.month = p[6], v.day = p[7], v.hour = p[8], v.minute = p[9], v.second = p[10];
  v.date_valid = (p[11] & 1U) != 0;
  v.time_valid = (p[11] & 2U) != 0;
  v.time_resolved = (p[11] & 4U) != 0;
  v.time_sigma_s = 1e-9 * load_le<std::uint32_t>(p + 12);
  v.nanosecond = load_le<std::int32_t>(p + 16);
  v.fix_type = p[20];
  v.fix_ok = (p[21] & 1U) != 0;
  v.differential = (p[21] & 2U) != 0;
  v.carrier_solution = p[21] >> 6;
  v.satellites = p[23];
  v.longitude_deg = 1e-7 * load_le<std::int32_t>(p + 24);
  v.latitude_deg = 1e-7 * load_le<std::int32_t>(p + 28);
  v.height_m = mm(32);
  v.height_above_sea_m = mm(36);
  v.horizontal_sigma_m = unsigned_mm(40);
  v.vertical_sigma_m = unsigned_mm(44);
  v.velocity_ned_mps = {mm(48), mm(52), mm(56)};
  v.ground_speed_mps = mm(60);
  v.course_deg = 1e-5 * load_le<std::int32_t>(p + 64);
  v.speed_sigma_mps = unsigned_mm(68);
  v.course_sigma_deg = 1e-5 * load_le<std::uint32_t>(p + 72);
  v.pdop = 0.01 * load_le<std::uint16_t>(p + 76);
  return v;
}

}  // namespace wayfare::decode
