#pragma once

#include <wayfare/sensors/point_set.hpp>

namespace wayfare {

struct WallPointsOptions {
  double spacing_m = 0.05;  ///< between the interpolated points
  double max_gap_m = 1.0;   ///< between neighbours on one wall
  double min_cos = 0.97;    ///< of the angle between a gap and the adjacent ones
};

/// A scan's end points, in the order of their beams, with points interpolated on straight walls
/// between neighbours. A wall seen at a shallow angle is otherwise a row of separate dots, the same
/// in the next scan wherever the robot moved along it, and matching would underestimate the motion.
[[nodiscard]] PointSet with_walls(const PointSet& ends, const WallPointsOptions& options);

}  // namespace wayfare
