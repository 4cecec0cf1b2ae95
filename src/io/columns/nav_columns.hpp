#pragma once

// Private: common parts of the readers and writers of navigation text.

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include <Eigen/Core>

#include <wayfare/core/geodesy.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/io/columns.hpp>
#include <wayfare/io/time_text.hpp>

#include "io/text/text.hpp"

namespace wayfare::io {

/// The columns of an RTKLIB solution (.pos) by its '%' heading; nullopt where `text` is not a
/// solution in geodetic coordinates.
std::optional<ColumnFormat> rtklib_columns(std::string_view text, const ColumnFormat& format);

/// Three numbers of a row, from `first` on.
inline Eigen::Vector3d triple(std::span<const double> numbers, std::size_t first) {
  return {numbers[first], numbers[first + 1], numbers[first + 2]};
}

/// From radians and metres; returns an error message, or an empty string.
inline std::string to_geodetic(const Eigen::Vector3d& lat_lon_h, Geodetic& position) {
  if (!lat_lon_h.allFinite()) return "the position is not finite";
  if (!(std::abs(lat_lon_h[0]) <= 1.5707963267948968)) return "the latitude is beyond a pole";
  if (!(std::abs(lat_lon_h[1]) <= 6.283185307179587)) return "the longitude is beyond 360 degrees";
  position = {Angle::radians(lat_lon_h[0]), Angle::radians(lat_lon_h[1]), lat_lon_h[2]};
  return {};
}

inline void append_time(std::string& out, LogTime time) {
  out += format_nanoseconds(time.nanoseconds());
}

using text::append_numbers;

inline void append_position(std::string& out, const Geodetic& p) {
  append_numbers(out, {p.latitude.degrees(), p.longitude.degrees(), p.height_m});
}

}  // namespace wayfare::io
