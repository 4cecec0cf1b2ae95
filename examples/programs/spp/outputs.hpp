#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/eval/table.hpp>
#include <wayfare/gnss/single_point.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/sensors/nav_state.hpp>

namespace wayfare::examples {

/// A finished run.
struct SppRun {
  std::string title;
  std::vector<SinglePoint> points;  ///< in order of time
  std::vector<RangeEpoch> ranges;   ///< corrected, all systems on GPS's clock
  std::size_t epochs = 0;           ///< observed
  NavTrajectory truth;              ///< may be empty
  bool truth_has_velocity = false;
  std::vector<GnssFix> peer;  ///< another program's solution; may be empty
  std::vector<std::pair<std::string, std::string>> facts;
};

/// North, east, down from the reference, where it has one on both sides at most 2 s apart.
struct PositionError {
  LogTime time;
  Eigen::Vector3d ned_m = Eigen::Vector3d::Zero();
  std::optional<Eigen::Vector3d> velocity_ned_mps;
  Eigen::Vector3d sigma_m = Eigen::Vector3d::Zero();
};
[[nodiscard]] std::vector<PositionError> errors_of(const SppRun& run);

/// Horizontal, vertical and velocity errors; on the peer's epochs too, and the peer's own.
[[nodiscard]] eval::Table error_table(const SppRun& run);

/// Makes `folder` where needed. With `Existing::refuse` it is an error where one of the files below
/// is in it already: to be asked before the work.
[[nodiscard]] Result<void> prepare_spp_folder(const std::string& folder,
                                              const io::WriteOptions& options);

/// Writes positions.txt (fixes), ranges.txt (corrected ranges), track.tum (east, north, up of the
/// first position, m) and report.html; gives the report's path.
[[nodiscard]] Result<std::string> write_spp_outputs(const std::string& folder, const SppRun& run,
                                                    const io::WriteOptions& options);

}  // namespace wayfare::examples
