#pragma once

#include <wayfare/sensors/point_set.hpp>

namespace wayfare {

struct WallPointsOptions {
  double spacing_m = 0.05;     ///< between the points made
  double longest_gap_m = 1.0;  ///< to a neighbour of the same wall
  double least_cos = 0.97;     ///< of the bend from a gap to those before and after it
};

/// A scan's end points, in the order of their beams, and points on the wall between neighbours
/// that run on straight. A wall seen at a shallow angle is otherwise a row of dots that lie the
/// same in the next scan, whatever way along it the robot went: matching would hold it back.
[[nodiscard]] PointSet with_walls(const PointSet& ends, const WallPointsOptions& options);

}  // namespace wayfare
