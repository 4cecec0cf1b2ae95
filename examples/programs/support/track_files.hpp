#pragma once

// Tracks on the Earth in the formats of other programs, beside a program's own files.

#include <span>
#include <string>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/io/track_formats.hpp>

#include "program_files.hpp"

namespace wayfare::examples {

/// kml, gpx, nmea, pos, ecef.
struct TrackFormats {
  std::vector<std::string> words;

  /// --track-formats.
  void add_option(CommandLine& app);
  /// `names`, and those of the files that the formats add: track.kml …
  [[nodiscard]] std::vector<std::string> with_files(std::vector<std::string> names) const;
};

/// Writes a file for each format into the folder.
[[nodiscard]] Result<void> write_track_files(const OutputArguments& to, const TrackFormats& formats,
                                             std::span<const GnssFix> fixes);
/// The same of states; standard deviations in .pos files are zero.
[[nodiscard]] Result<void> write_track_files(const OutputArguments& to, const TrackFormats& formats,
                                             std::span<const NavState> track);

}  // namespace wayfare::examples
