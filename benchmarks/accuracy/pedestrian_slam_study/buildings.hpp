#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/time.hpp>
#include <wayfare/sim/floor_plan.hpp>

namespace wayfare::examples {

struct Walk {
  std::string name;
  std::vector<Eigen::Vector2d> route_m;
  sim::FloorPlan plan;  ///< bare corridors of 2 m along the route
  /// Time from a scan's first beam to its last; 0: all at one instant.
  Duration sweep{0};
  bool beams_have_times = true;  ///< false: the scans of a sweep look instantaneous
};

/// A rectangle of 42 m, a figure eight of 86 m, and a hallway of 42 m, walked both ways, with a
/// ring of corridors at its end, 122 m.
[[nodiscard]] std::vector<Walk> study_walks();
/// 20 m straight ahead, in a hall.
[[nodiscard]] std::vector<Eigen::Vector2d> calibration_route();

}  // namespace wayfare::examples
