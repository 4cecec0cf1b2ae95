#pragma once

// Sentences of GNSS receivers: $ or !, talker and type, fields separated by commas, * and a
// checksum of two hexadecimal digits, the exclusive or of all between (NMEA 0183 4.11,
// section 5.3).
//
//   NmeaDecoder decoder;
//   decoder.feed(bytes, [](const NmeaSentence& s) {
//     if (const auto fix = nmea_gga(s)) use(fix->latitude_deg, fix->longitude_deg);
//   });

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <system_error>

#include <wayfare/core/detail/bytes.hpp>
#include <wayfare/decode/stream_decoder.hpp>

namespace wayfare::decode {

/// A sentence whose checksum is right. It refers to the decoder's bytes.
class NmeaSentence {
 public:
  NmeaSentence() = default;
  /// All bytes of a sentence, at this position in the stream.
  NmeaSentence(std::uint64_t position, Bytes bytes) : position_(position), bytes_(bytes) {}

  /// "GP", "GN" …; "P" of a proprietary sentence.
  [[nodiscard]] std::string_view talker() const { return address().substr(0, talker_length()); }
  /// "GGA", "RMC" …
  [[nodiscard]] std::string_view type() const {
    const std::string_view all = address();
    return all.substr(std::min(talker_length(), all.size()));
  }
  /// Field `i` behind the type, from 0; empty where there is none.
  [[nodiscard]] std::string_view field(std::size_t i) const {
    std::string_view rest = content();
    for (;; --i) {
      const std::size_t comma = rest.find(',');
      if (comma == rest.npos) return {};
      rest.remove_prefix(comma + 1);
      if (i == 0) return rest.substr(0, rest.find(','));
    }
  }
  /// A field as a number; nullopt where it is empty or not a finite number.
  [[nodiscard]] std::optional<double> number(std::size_t i) const {
    const std::string_view text = field(i);
    double value = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (text.empty() || error != std::errc() || end != text.data() + text.size()) return {};
    return std::isfinite(value) ? std::optional(value) : std::nullopt;
  }
  [[nodiscard]] std::uint64_t position() const { return position_; }  ///< in the stream
  [[nodiscard]] Bytes bytes() const { return bytes_; }                ///< from $ to the checksum

 private:
  /// Between $ and *.
  [[nodiscard]] std::string_view content() const {
    const std::string_view all(reinterpret_cast<const char*>(bytes_.data()), bytes_.size());
    return all.substr(1, all.find('*') - 1);
  }
  [[nodiscard]] std::string_view address() const {
    const std::string_view all = content();
    return all.substr(0, all.find(','));
  }
  [[nodiscard]] std::size_t talker_length() const { return address().starts_with('P') ? 1 : 2; }

  std::uint64_t position_ = 0;
  Bytes bytes_;
};

/// Framing of sentences. Line ends are not part of a frame; like other bytes between sentences they
/// count as skipped. A sentence longer than 1024 bytes is none: the standard allows 82, receivers
/// write more, u-blox's PUBX,03 some 25 for each satellite.
class NmeaFraming {
 public:
  using Message = NmeaSentence;                   ///< what the sink is given
  static constexpr std::size_t kCapacity = 1024;  ///< bytes of the largest frame

  /// What begins at the front.
  Look look(const Front& front, DecoderStatistics& statistics) {
    const Bytes b = front.bytes;
    if (!starts(b[0])) return Look::skip(until_start(b));
    if (start_ != front.position) {
      start_ = front.position;
      scanned_ = 1;
      sum_ = 0;
    }
    for (; scanned_ < b.size(); ++scanned_, ++examined_) {
      const std::uint8_t c = b[scanned_];
      if (c == '*') return checked(b, statistics);
      if (c < 0x20 || c > 0x7E || starts(c)) return ended(scanned_, statistics);
      sum_ = static_cast<std::uint8_t>(sum_ ^ c);
    }
    if (b.size() + 1 > kCapacity) return ended(b.size(), statistics);
    return Look::need(b.size() + 1);
  }

  /// Gives the sink the message of a frame.
  template <class Sink>
  void deliver(Bytes bytes, std::uint64_t position, Sink& sink) {
    const NmeaSentence sentence(position, bytes);
    sink(sentence);
  }
  /// Bytes compared or added so far.
  [[nodiscard]] std::uint64_t examined() const { return examined_; }

 private:
  static bool starts(std::uint8_t c) { return c == '$' || c == '!'; }
  static int digit(std::uint8_t c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    return -1;
  }

  std::size_t until_start(Bytes b) {
    std::size_t n = 1;
    while (n < b.size() && !starts(b[n])) ++n;
    examined_ += n;
    return n;
  }

  /// The bytes before `at` contain no whole sentence and no other start.
  Look ended(std::size_t at, DecoderStatistics& statistics) {
    ++statistics.malformed;
    return Look::skip(at);
  }

  Look checked(Bytes b, DecoderStatistics& statistics) {
    const std::size_t total = scanned_ + 3;
    if (total > kCapacity) return ended(scanned_, statistics);
    if (b.size() < total) return Look::need(total);
    const int high = digit(b[scanned_ + 1]), low = digit(b[scanned_ + 2]);
    const std::size_t star = scanned_;
    if (high < 0 || low < 0 || star < 6) return ended(star + 1, statistics);
    if (16 * high + low == sum_) return Look::frame(total);
    ++statistics.checksum_failures;
    return Look::skip(star + 1);
  }

  std::uint64_t start_ = static_cast<std::uint64_t>(-1);  ///< position of the sentence's first byte
  std::size_t scanned_ = 0;  ///< its bytes that were searched for the end
  std::uint8_t sum_ = 0;     ///< of them
  std::uint64_t examined_ = 0;
};

/// Decodes a receiver's stream.
using NmeaDecoder = StreamDecoder<NmeaFraming>;

/// Time of day and position of a GGA sentence.
struct NmeaFix {
  double time_of_day_s = 0.0;  ///< UTC
  double latitude_deg = 0.0;   ///< north positive
  double longitude_deg = 0.0;  ///< east positive
  int quality = 0;  ///< 0 none, 1 GNSS, 2 differential, 4 fixed, 5 float ambiguities, 6 estimated
  int satellites = 0;                        ///< used
  std::optional<double> hdop;                ///< dilution of precision, horizontal
  std::optional<double> height_above_sea_m;  ///< mean sea level
  std::optional<double> geoid_m;             ///< height of the geoid above the ellipsoid
};

/// Date, position and velocity over ground of an RMC sentence.
struct NmeaMotion {
  double time_of_day_s = 0.0;        ///< UTC
  int year = 0;                      ///< 1980 to 2079
  int month = 0;                     ///< 1 to 12
  int day = 0;                       ///< 1 to 31
  bool valid = false;                ///< else a warning of the receiver
  double latitude_deg = 0.0;         ///< north positive
  double longitude_deg = 0.0;        ///< east positive
  std::optional<double> speed_mps;   ///< over ground
  std::optional<double> course_deg;  ///< clockwise from true north
};

namespace detail {

/// hhmmss.sss as seconds of the day.
[[nodiscard]] inline std::optional<double> nmea_time(const NmeaSentence& s, std::size_t field) {
  const std::optional<double> value = s.number(field);
  if (!value || *value < 0.0 || *value >= 240000.0) return std::nullopt;
  const double hours = std::floor(*value / 1e4), minutes = std::floor(*value / 1e2) - 100.0 * hours;
  const double seconds = *value - 1e4 * hours - 1e2 * minutes;
  if (minutes > 59.0 || seconds >= 61.0) return std::nullopt;  // 60 is a leap second
  return 3600.0 * hours + 60.0 * minutes + seconds;
}

/// ddmm.mmm and the hemisphere in the next field, as degrees.
[[nodiscard]] inline std::optional<double> nmea_angle(const NmeaSentence& s, std::size_t field,
                                                      char positive, char negative,
                                                      double largest_deg) {
  const std::optional<double> value = s.number(field);
  const std::string_view side = s.field(field + 1);
  if (!value || *value < 0.0 || side.size() != 1) return std::nullopt;
  const double degrees = std::floor(*value / 100.0), minutes = *value - 100.0 * degrees;
  const double angle = degrees + minutes / 60.0;
  if (minutes >= 60.0 || angle > largest_deg) return std::nullopt;
  if (side[0] == positive) return angle;
  return side[0] == negative ? std::optional(-angle) : std::nullopt;
}

[[nodiscard]] inline std::optional<int> nmea_count(const NmeaSentence& s, std::size_t field) {
  const std::optional<double> value = s.number(field);
  if (!value || *value < 0.0 || *value > 1e6 || *value != std::floor(*value)) return std::nullopt;
  return static_cast<int>(*value);
}

}  // namespace detail

/// Nullopt for another sentence, or one without a time or position.
[[nodiscard]] inline std::optional<NmeaFix> nmea_gga(const NmeaSentence& s) {
  if (s.type() != "GGA") return std::nullopt;
  const auto time = detail::nmea_time(s, 0);
  const auto latitude = detail::nmea_angle(s, 1, 'N', 'S', 90.0);
  const auto longitude = detail::nmea_angle(s, 3, 'E', 'W', 180.0);
  const auto quality = detail::nmea_count(s, 5);
  if (!time || !latitude || !longitude || !quality) return std::nullopt;
  return NmeaFix{
      *time,       *latitude,   *longitude,  *quality, detail::nmea_count(s, 6).value_or(0),
      s.number(7), s.number(8), s.number(10)};
}

/// Nullopt for another sentence, or one without a time, date or position.
[[nodiscard]] inline std::optional<NmeaMotion> nmea_rmc(const NmeaSentence& s) {
  constexpr double kKnot_mps = 1852.0 / 3600.0;
  if (s.type() != "RMC") return std::nullopt;
  const auto time = detail::nmea_time(s, 0);
  const auto latitude = detail::nmea_angle(s, 2, 'N', 'S', 90.0);
  const auto longitude = detail::nmea_angle(s, 4, 'E', 'W', 180.0);
  const auto date = detail::nmea_count(s, 8);
  if (!time || !latitude || !longitude || !date || s.field(8).size() != 6) return std::nullopt;
  const int year = *date % 100, month = *date / 100 % 100, day = *date / 10000;
  if (month < 1 || month > 12 || day < 1 || day > 31) return std::nullopt;
  std::optional<double> speed = s.number(6);
  if (speed) *speed *= kKnot_mps;
  return NmeaMotion{*time,
                    year < 80 ? 2000 + year : 1900 + year,
                    month,
                    day,
                    s.field(1) == "A",
                    *latitude,
                    *longitude,
                    speed,
                    s.number(7)};
}

}  // namespace wayfare::decode
