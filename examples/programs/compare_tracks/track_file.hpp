#pragma once

// A track of any format, local or on the Earth.

#include <string>

#include <wayfare/core/geodesy.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/eval/track_comparison.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/sensors/trajectory.hpp>

namespace wayfare::examples {

struct TrackFile {
  std::string path;
  eval::Track local;         ///< empty of one on the Earth
  NavTrajectory geographic;  ///< empty of a local one
  bool has_height = true;

  [[nodiscard]] bool is_geographic() const { return !geographic.empty(); }
  [[nodiscard]] std::size_t size() const { return local.size() + geographic.size(); }
};

/// TUM text, columns (positions on the Earth, or x and y), RTKLIB's .pos, GPX, KML with times,
/// NMEA, UBX. Errors: those of the readers; a line that cannot be read, of which there must be
/// none.
[[nodiscard]] Result<TrackFile> read_track(const std::string& path, const io::ColumnFormat& format);

/// East, north, up from `origin`; a local track as it is.
[[nodiscard]] eval::Track in_local_axes(const TrackFile& file, const Geodetic& origin);

}  // namespace wayfare::examples
