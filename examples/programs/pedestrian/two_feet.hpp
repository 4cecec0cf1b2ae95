#pragma once

// A walk by a unit on each foot: each alone, and with the bound on their distance.

#include <optional>
#include <string>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/io/tum.hpp>
#include <wayfare/pedestrian/two_feet.hpp>

#include "ahrs/recording.hpp"
#include "support/program_files.hpp"
#include "support/truth.hpp"

namespace wayfare::examples {

/// The unit on the right foot, on the clock of the left one.
struct RightFoot {
  std::string file;
  std::vector<std::string> columns;
  double farthest_m = 1.0;
  double width_m = 0.2;               ///< from the left foot to the right, at the start
  std::optional<double> heading_deg;  ///< of the right unit's axes from the left one's

  void add_options(CommandLine& app);
  [[nodiscard]] Result<io::MargFile> read(const RecordingOptions& left) const;
};

/// Poses of one run in the left foot's axes, at each reading.
struct FeetTracks {
  io::Trajectory3 left, right;
  Trajectory middle;
  std::size_t left_stances = 0, right_stances = 0;
  std::uint64_t projections = 0;
};

struct TwoFeetRun {
  FeetTracks alone, bound;
  TwoFeetParameters parameters;
  bool heading_known = false;  ///< of the right unit, else estimated from the tracks
};

/// Errors: a foot without an attitude, times that do not overlap, a walk too short for the headings
/// of the units.
[[nodiscard]] Result<TwoFeetRun> run_two_feet(const MargRecording& left, const MargRecording& right,
                                              const FootParameters& foot, const RightFoot& options);

/// Writes left.tum, right.tum, trajectory.tum (the midpoint) and report.html. The truth of the
/// midpoint may be unknown.
[[nodiscard]] Result<void> write_two_feet(const OutputArguments& to, const std::string& title,
                                          const TwoFeetRun& run, const Truth& truth);
[[nodiscard]] std::string two_feet_text(const TwoFeetRun& run, const Truth& truth);

}  // namespace wayfare::examples
