#pragma once

// Private: common parts of RINEX files: fixed columns, header labels, dates; and the header of an
// observation file: its properties, and the indices of each signal in a satellite's list of values.

#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/gnss/ephemerides.hpp>
#include <wayfare/gnss/gps_time.hpp>
#include <wayfare/io/rinex.hpp>

#include "io/text/text.hpp"

namespace wayfare::io::rinex {

/// Columns from `begin`, at most `length`; empty beyond the end of the line.
inline std::string_view columns(std::string_view line, std::size_t begin, std::size_t length) {
  return begin < line.size() ? line.substr(begin, length) : std::string_view();
}

using text::trimmed;

inline bool is_blank(std::string_view text) { return trimmed(text).empty(); }

/// Reads a number from a field, without its blanks.
template <class T>
bool field(std::string_view line, std::size_t begin, std::size_t length, T& value) {
  return text::to_number(trimmed(columns(line, begin, length)), value);
}

/// A number with Fortran's exponent, "1.0D+02" or "-.34d-3"; nullopt where it is not one.
inline std::optional<double> fortran_number(std::string_view text) {
  text = trimmed(text);
  char buffer[32];
  if (text.empty() || text.size() > sizeof buffer) return std::nullopt;
  for (std::size_t i = 0; i < text.size(); ++i)
    buffer[i] = text[i] == 'D' || text[i] == 'd' ? 'e' : text[i];
  double value = 0.0;
  if (!text::to_number(std::string_view(buffer, text.size()), value) || !std::isfinite(value))
    return std::nullopt;
  return value;
}

/// Years of two digits are 1980 to 2079.
inline int full_year(int year) { return year >= 100 ? year : year + (year < 80 ? 2000 : 1900); }

/// Year, month, day, hour, minute, second, separated by blanks.
std::optional<CivilTime> civil_time(std::string_view text);

/// A calendar time of a file, in its time scale.
enum class TimeScale { gps, utc, beidou };
std::optional<Time<GpsClock>> gps_from(const CivilTime& civil, TimeScale scale,
                                       std::span<const LeapSecond> leaps);

/// The first line of a file.
struct FirstLine {
  double version = 0.0;
  char type = ' ';    ///< O observations, N navigation, G GLONASS navigation (version 2) …
  char system = ' ';  ///< of the whole file; M mixed
};
Result<FirstLine> first_line(std::string_view line, const std::string& source);

/// The label of a header line, in columns 61 to 80.
inline std::string_view label(std::string_view line) { return trimmed(columns(line, 60, 20)); }

/// Indices of a signal's parts in a satellite's list of values; −1: not in the list.
struct SignalPlaces {
  int code = -1, doppler = -1, phase = -1, strength = -1;
  char band = '1';
};

/// Stores properties and problems in the file passed to the constructor.
class ObservationHeader {
 public:
  ObservationHeader(const FirstLine& first, const std::string& source, const RinexOptions& options,
                    RinexObservations& file);

  /// Parses one line, of the header or after an event; finish() applies the lists of types.
  void take(std::string_view line, std::size_t number);
  void finish();

  [[nodiscard]] bool version_2() const { return version_2_; }
  /// The system of satellites whose names lack one.
  [[nodiscard]] char default_letter() const { return default_letter_; }
  [[nodiscard]] TimeScale time_scale() const { return scale_; }
  /// Number of values per satellite in version 2.
  [[nodiscard]] std::size_t values_of_version_2() const { return types_of_all_.size(); }
  /// Of the requested signals, in their order.
  [[nodiscard]] const std::vector<SignalPlaces>& places(GnssSystem system) const {
    return places_[index_of(system)];
  }

 private:
  /// The RINEX 3 names of each value of a satellite.
  using Types = std::vector<std::vector<std::string>>;
  static constexpr std::size_t kMaxTypes = 999;

  void types_of_system(std::string_view line, std::size_t number);
  void types_of_all(std::string_view line, std::size_t number);
  void time_system(std::string_view name, std::size_t number);
  void glonass_channels(std::string_view line);
  void report(std::size_t line, std::string message);
  [[nodiscard]] std::vector<SignalPlaces> places_among(GnssSystem system, const Types& types) const;

  const std::string& source_;
  const RinexOptions& options_;
  RinexObservations& file_;
  bool version_2_;
  char default_letter_;
  TimeScale scale_ = TimeScale::gps;
  char types_letter_ = ' ';
  std::array<Types, 256> types_;  ///< by system letter
  Types types_of_all_;            ///< version 2
  std::array<std::vector<SignalPlaces>, kGnssSystems> places_;
};

}  // namespace wayfare::io::rinex
