#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/pedestrian/parameters.hpp>
#include <wayfare/sensors/measurements.hpp>
#include <wayfare/sensors/recording.hpp>
#include <wayfare/sim/walks.hpp>

#include "buildings.hpp"

namespace wayfare::examples {

struct RecordedWalk {
  MargRecording unit;
  std::vector<LaserScan> scans;
  Trajectory truth;  ///< of the levelled unit, at the scans' times
};

struct SimulatedWalk {
  sim::HeadWalk head;
  RecordedWalk recorded;
  double step_m;  ///< as calibrated

  /// The levelled unit's pose.
  [[nodiscard]] StampedPose truth_at(LogTime time) const;
};

[[nodiscard]] SimulatedWalk simulate_walk(const Walk& walk, std::uint64_t seed,
                                          const sim::HeadWalk::UnitNoise& noise = {});

/// Steps of constant length; a unit on the head, x ahead, without magnetometer.
[[nodiscard]] PedestrianParameters head_pedestrian(double step_m);

/// Root mean square of the planar distance over the scans' times, both started from the same pose
/// (Sadruddin 2020, (5.1)).
[[nodiscard]] double rmse_m(const Trajectory& estimate, const Trajectory& truth);

/// Writes scans and truth as walk.log, the unit's readings as unit.csv.
[[nodiscard]] Result<void> write_walk(const Walk& walk, std::uint64_t seed,
                                      const std::string& folder);

/// Its walls as the text of a floor plan.
[[nodiscard]] Result<void> write_plan(const sim::FloorPlan& plan, const std::string& path);

}  // namespace wayfare::examples
