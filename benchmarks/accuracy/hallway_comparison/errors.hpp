#pragma once

#include <wayfare/sensors/recording.hpp>

namespace wayfare::examples {

/// A run's errors, root mean squares: in the map's axes as the published table has them, and of the
/// motion over straight stretches of 5 m in the robot's own.
struct Errors {
  double x_m = 0.0, y_m = 0.0, heading_deg = 0.0;
  double along_m = 0.0, across_m = 0.0, turn_deg = 0.0;
};

[[nodiscard]] Errors errors_of(const Trajectory& estimate, const Trajectory& truth);

}  // namespace wayfare::examples
