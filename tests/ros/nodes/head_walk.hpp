#pragma once

// A walker with an inertial unit and a range finder on the head, through two rooms.

#include <vector>

#include <wayfare/sensors/measurements.hpp>
#include <wayfare/sensors/recording.hpp>
#include <wayfare/sim/walks.hpp>
#include "sim/support.hpp"

namespace wayfare::testing {

struct HeadWalk {
  MargRecording unit;
  Recording log;                         ///< of the laser, at the origin of the base
  std::vector<Eigen::Vector2d> truth_m;  ///< at the scans
};

/// From `start` on; without clock errors. Four seconds at rest before and after.
inline HeadWalk head_walk(LogTime start, const std::string& route = "a b c") {
  const sim::PlannedRoute planned_route = planned(office_plan(route));
  Rng rng(1);
  const sim::HeadWalk head(planned_route.route_m, {}, rng.stream(1));
  HeadWalk walk;
  walk.unit = head.unit(100.0, {}, rng);
  const Duration since = start - LogTime();
  for (MargSample& s : walk.unit) s.time += since;
  for (double t = 1.0; t < head.duration_s(); t += 1 / 5.5) {
    const auto pose = head.at(t);
    walk.truth_m.emplace_back(pose.position_m.head<2>());
    walk.log.scans.push_back(
        sim::scan_from_head(planned_route.plan, pose, start + from_seconds(t), {}, rng));
  }
  return walk;
}

}  // namespace wayfare::testing
