#pragma once

#include <wayfare/sensors/recording.hpp>

namespace wayfare::examples {

/// Root mean square errors: in the map's axes, as in the published table, and of the motion over
/// straight segments of 5 m in the robot's axes.
struct Errors {
  double x_m = 0.0, y_m = 0.0, heading_deg = 0.0;
  double along_m = 0.0, across_m = 0.0, rotation_deg = 0.0;
};

[[nodiscard]] Errors errors_of(const Trajectory& estimate, const Trajectory& truth);

}  // namespace wayfare::examples
