#pragma once

#include <optional>
#include <string>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/gnss/single_point.hpp>
#include <wayfare/sensors/trajectory.hpp>

#include "support/program_files.hpp"
#include "support/track_files.hpp"

namespace wayfare::examples {

/// A finished run.
struct SppRun {
  std::string title;
  std::vector<SinglePoint> points;  ///< sorted by time
  std::vector<RangeEpoch> ranges;   ///< corrected, all systems on the GPS clock
  std::size_t epochs = 0;           ///< observed
  NavTrajectory truth;              ///< may be empty
  bool truth_has_velocity = false;
  std::vector<GnssFix> peer;  ///< another program's solution; may be empty
  Facts facts;
};

/// Horizontal, vertical and velocity errors; with a peer, also at its epochs, and its errors.
[[nodiscard]] eval::Table error_table(const SppRun& run);

/// How often errors are within their bounds, by whether the solution is consistent.
[[nodiscard]] eval::Table bounds_table(const SppRun& run);

/// Writes positions.txt (fixes), ranges.txt (corrected ranges), track.tum (east, north, up from the
/// first position, m), report.html and the track in other formats; without a folder only what
/// --json asks for.
[[nodiscard]] Result<void> write_spp_outputs(const OutputArguments& to, const TrackFormats& formats,
                                             const SppRun& run);

}  // namespace wayfare::examples
