#pragma once

// Speed along a path within the vehicle's limits.

#include <vector>

#include <wayfare/sim/vehicle_trajectory.hpp>

#include "sim/vehicle/waypoint_path.hpp"

namespace wayfare::sim {

/// Distance along the path over time: constant acceleration between grid points, with stops.
class SpeedProfile {
 public:
  SpeedProfile(const WaypointPath& path, const VehicleLimits& limits);

  [[nodiscard]] double duration_s() const { return marks_.back().time_s; }
  [[nodiscard]] double along_m(double t) const;
  /// Mean over the `width` before `t`, s, which makes the acceleration continuous.
  [[nodiscard]] double smooth_along_m(double t, double width) const;

 private:
  struct Mark {
    double time_s, along_m, speed_mps;
  };

  void lay_out(const std::vector<double>& speed, const std::vector<double>& stand, double ds);

  std::vector<Mark> marks_;
};

}  // namespace wayfare::sim
