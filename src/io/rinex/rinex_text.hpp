#pragma once

// Private: common parts of RINEX files: fixed columns, header labels, dates.

#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include <wayfare/core/result.hpp>
#include <wayfare/gnss/gps_time.hpp>

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

}  // namespace wayfare::io::rinex
