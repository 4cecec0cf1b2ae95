#pragma once

// The walls measured from scan to scan: changes of their normal points, and their angle by two
// methods (Liu 2015, figures 9 and 16 c).

#include <string>
#include <vector>

#include <wayfare/io/report.hpp>
#include <wayfare/nav/corridor_ins.hpp>
#include <wayfare/sensors/recording.hpp>

#include "support/program_files.hpp"

namespace wayfare::examples {

/// Walls of one scan and of the one before it; NaN where a wall or the truth is missing.
struct WallChange {
  LogTime time;
  double left_m, right_m;              ///< change of the distance of either wall
  double angle_deg;                    ///< change of their direction
  double left_error_m, right_error_m;  ///< of these changes, with the true motion
  double angle_error_deg;
  double fitted_deg, searched_deg;  ///< direction in this scan: least squares, and by correlation
};

/// Of every scan that has walls. `truth` may be empty.
[[nodiscard]] std::vector<WallChange> wall_changes(const Recording& recording,
                                                   const CorridorRun& run, const Trajectory& truth,
                                                   const WallOptions& options);

[[nodiscard]] std::string to_csv(const std::vector<WallChange>& changes);
/// Root mean square of the errors, and of the difference of both methods.
[[nodiscard]] Facts facts_of(const std::vector<WallChange>& changes);
[[nodiscard]] std::vector<io::Plot> plots_of(const std::vector<WallChange>& changes);

}  // namespace wayfare::examples
