#pragma once

// Messages of u-blox receivers, little endian: B5 62, class, id, length of the payload in two
// bytes, payload, two bytes of checksum (u-blox, F9 HPG 1.32 Interface Description, UBX-22008968).
//
//   UbxDecoder decoder;
//   decoder.feed(bytes, [](const UbxMessage& m) {
//     if (const auto raw = rxm_rawx(m)) use(raw->epoch(), raw->measurement(0));
//   });

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <span>

#include <wayfare/core/detail/bytes.hpp>
#include <wayfare/decode/stream_decoder.hpp>

namespace wayfare::decode {

/// Class and id of the messages with a type here.
enum class UbxId : std::uint16_t {
  nav_pvt = 0x0107,
  rxm_sfrbx = 0x0213,
  rxm_rawx = 0x0215,
};

/// A message whose checksum is right. It refers to the decoder's bytes.
class UbxMessage {
 public:
  UbxMessage() = default;
  UbxMessage(std::uint64_t position, Bytes bytes) : position_(position), bytes_(bytes) {}

  /// Class in the upper byte, id in the lower one.
  [[nodiscard]] UbxId id() const { return static_cast<UbxId>(bytes_[2] << 8 | bytes_[3]); }
  [[nodiscard]] Bytes payload() const { return bytes_.subspan(6, bytes_.size() - 8); }
  [[nodiscard]] std::uint64_t position() const { return position_; }
  [[nodiscard]] Bytes bytes() const { return bytes_; }

 private:
  std::uint64_t position_ = 0;
  Bytes bytes_;
};

namespace detail {

/// Fletcher's checksum of 8 bits (RFC 1145), as the receivers compute it.
struct Fletcher8 {
  std::uint8_t a = 0, b = 0;
  void add(std::uint8_t byte) {
    a = static_cast<std::uint8_t>(a + byte);
    b = static_cast<std::uint8_t>(b + a);
  }
};

}  // namespace detail

/// Writes a message to `out`; returns its length, or 0 where it does not fit.
[[nodiscard]] inline std::size_t write_ubx(UbxId id, Bytes payload, std::span<std::uint8_t> out) {
  const std::size_t total = payload.size() + 8;
  if (payload.size() > 0xFFFF || out.size() < total) return 0;
  out[0] = 0xB5;
  out[1] = 0x62;
  store_be(static_cast<std::uint16_t>(id), &out[2]);
  store_le(static_cast<std::uint16_t>(payload.size()), &out[4]);
  if (!payload.empty()) std::memcpy(&out[6], payload.data(), payload.size());
  detail::Fletcher8 sum;
  for (std::size_t i = 2; i < total - 2; ++i) sum.add(out[i]);
  out[total - 2] = sum.a;
  out[total - 1] = sum.b;
  return total;
}

/// Framing of the messages. A payload longer than `kMaxPayload` bytes is rejected as damaged. The
/// longest of the messages here is RXM-RAWX with 255 measurements, 8176 bytes.
///
/// After a wrong checksum the search resumes one byte later, with overlapping candidates. Their
/// checksums are differences of running sums, so that no byte is added more than twice.
template <std::size_t kMaxPayload = 8192>
class BasicUbxFraming {
 public:
  using Message = UbxMessage;
  static constexpr std::size_t kCapacity = kMaxPayload + 8;

  Look look(const Front& front, DecoderStatistics& statistics) {
    const Bytes b = front.bytes;
    if (b[0] != 0xB5) return Look::skip(until_start(b));
    if (b.size() < 2) return Look::need(2);
    if (b[1] != 0x62) return Look::skip(1);
    if (b.size() < 6) return Look::need(6);
    const std::size_t length = load_le<std::uint16_t>(&b[4]);
    if (length > kMaxPayload) {
      ++statistics.malformed;
      return Look::skip(1);
    }
    const std::size_t total = length + 8;
    if (b.size() < total) return Look::need(total);
    if (checksum_matches(b.first(total), front.position)) return Look::frame(total);
    ++statistics.checksum_failures;
    return Look::skip(1);
  }

  template <class Sink>
  void deliver(Bytes bytes, std::uint64_t position, Sink& sink) {
    const UbxMessage message(position, bytes);
    sink(message);
  }
  [[nodiscard]] std::uint64_t examined() const { return examined_; }

 private:
  /// Σ of all bytes before a position since the search began, and Σ of these sums, modulo 256.
  struct Sums {
    std::uint8_t a, b;
  };

  std::size_t until_start(Bytes b) {
    const void* next = std::memchr(b.data(), 0xB5, b.size());
    const std::size_t n =
        next == nullptr
            ? b.size()
            : static_cast<std::size_t>(static_cast<const std::uint8_t*>(next) - b.data());
    examined_ += n;
    return n;
  }

  bool checksum_matches(Bytes b, std::uint64_t position) {
    if (summed_ <= position) {
      summed_ = position;
      at(position) = {0, 0};
    }
    for (; summed_ < position + b.size(); ++summed_, ++examined_) {
      const Sums before = at(summed_);
      const auto a = static_cast<std::uint8_t>(before.a + b[summed_ - position]);
      at(summed_ + 1) = {a, static_cast<std::uint8_t>(before.b + a)};
    }
    // The checksum is over n bytes from `first` on: a = A(end) − A(first), and each of its partial
    // sums is A(k) − A(first), so that b = B(end) − B(first) − n A(first).
    const std::size_t n = b.size() - 4;
    const Sums first = at(position + 2), end = at(position + 2 + n);
    const auto a = static_cast<std::uint8_t>(end.a - first.a);
    const auto sum =
        static_cast<std::uint8_t>(end.b - first.b - static_cast<unsigned>(n) * first.a);
    return b[b.size() - 2] == a && b[b.size() - 1] == sum;
  }

  Sums& at(std::uint64_t position) { return sums_[position % sums_.size()]; }

  std::array<Sums, std::bit_ceil(kCapacity + 1)> sums_;  // NOLINT: set before it is used
  std::uint64_t summed_ = 0;                             ///< sums are valid up to here
  std::uint64_t examined_ = 0;
};

using UbxFraming = BasicUbxFraming<>;
using UbxDecoder = StreamDecoder<UbxFraming>;

/// Satellite systems as the receiver numbers them.
enum class UbxGnss : std::uint8_t {
  gps = 0,
  sbas = 1,
  galileo = 2,
  beidou = 3,
  qzss = 5,
  glonass = 6,
  navic = 7,
};

/// Time of a RXM-RAWX message, by the receiver's clock.
struct UbxRawxEpoch {
  double time_of_week_s = 0.0;  ///< GPS time
  int week = 0;                 ///< GPS week
  int leap_seconds = 0;         ///< GPS − UTC
  bool leap_seconds_known = false;
  bool clock_reset = false;  ///< the receiver's clock was set since the last message
};

/// A satellite's signal in a RXM-RAWX message. Standard deviations are the receiver's estimates.
struct UbxMeasurement {
  double pseudorange_m = 0.0;
  double carrier_phase_cycles = 0.0;
  float doppler_hz = 0.0F;  ///< positive for an approaching satellite
  UbxGnss gnss = UbxGnss::gps;
  int satellite = 0;
  int signal = 0;            ///< sigId of table 1.5.4 there
  int glonass_channel = 0;   ///< −7 to 6, of GLONASS
  double lock_time_s = 0.0;  ///< of the carrier loop, at most 64.5 s
  int cn0_db_hz = 0;
  double pseudorange_sigma_m = 0.0;
  double carrier_phase_sigma_cycles = 0.0;  ///< infinite: not known
  double doppler_sigma_hz = 0.0;
  bool pseudorange_valid = false;
  bool carrier_phase_valid = false;
  bool half_cycle_resolved = false;    ///< else the phase may be off by half a cycle
  bool half_cycle_subtracted = false;  ///< from the phase
};

/// RXM-RAWX: ranges, Doppler shifts and carrier phases of one epoch.
class UbxRawx {
 public:
  explicit UbxRawx(Bytes payload) : payload_(payload) {}

  [[nodiscard]] UbxRawxEpoch epoch() const {
    const std::uint8_t status = payload_[12];
    return {load_le<double>(&payload_[0]), load_le<std::uint16_t>(&payload_[8]),
            load_le<std::int8_t>(&payload_[10]), (status & 1U) != 0, (status & 2U) != 0};
  }
  /// Number of measurements.
  [[nodiscard]] std::size_t size() const { return payload_[11]; }
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
  explicit UbxSubframe(Bytes payload) : payload_(payload) {}

  [[nodiscard]] UbxGnss gnss() const { return static_cast<UbxGnss>(payload_[0]); }
  [[nodiscard]] int satellite() const { return payload_[1]; }
  [[nodiscard]] int signal() const { return payload_[2]; }  ///< sigId, 0 in old firmware
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
  int year = 0, month = 0, day = 0, hour = 0, minute = 0, second = 0;  ///< UTC
  std::int32_t nanosecond = 0;  ///< of the second, may be negative
  bool date_valid = false, time_valid = false, time_resolved = false;
  double time_sigma_s = 0.0;
  int fix_type = 0;  ///< 0 none, 1 dead reckoning, 2 2D, 3 3D, 4 with dead reckoning, 5 time only
  bool fix_ok = false;  ///< within the receiver's limits of accuracy
  bool differential = false;
  int carrier_solution = 0;  ///< 0 none, 1 float, 2 fixed ambiguities
  int satellites = 0;        ///< used
  double longitude_deg = 0.0, latitude_deg = 0.0;
  double height_m = 0.0;  ///< above the ellipsoid
  double height_above_sea_m = 0.0;
  double horizontal_sigma_m = 0.0, vertical_sigma_m = 0.0;
  std::array<double, 3> velocity_ned_mps = {};
  double ground_speed_mps = 0.0;
  double course_deg = 0.0;  ///< of the motion, clockwise from north
  double speed_sigma_mps = 0.0;
  double course_sigma_deg = 0.0;
  double pdop = 0.0;
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
