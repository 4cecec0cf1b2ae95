#pragma once

// Errors of a run against the truth, both started from the same pose, without further alignment.

#include <algorithm>
#include <cmath>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/sensors/recording.hpp>
#include <wayfare/sensors/trajectory.hpp>

namespace wayfare::examples {

struct StartErrors {
  double x_m = 0.0, y_m = 0.0, heading_deg = 0.0;  ///< root mean square, in the map's axes
  double end_m = 0.0, worst_m = 0.0;
  std::vector<double> times_s, distances_m;  ///< of every pose, times since the first
};

/// In the axes of the estimate's frame. An error if the truth does not cover the first pose.
[[nodiscard]] inline Result<StartErrors> start_errors(const Trajectory& estimate,
                                                      const Trajectory& truth) {
  if (estimate.empty()) return Error{ErrorCode::not_found, "the run has no poses"};
  const auto start = pose_at(truth, estimate.front().time);
  if (!start) return Error{ErrorCode::not_found, "the truth does not cover the run"};
  const SE2d T_map_truth = estimate.front().T_map_base.raw() * start->inverse();
  StartErrors e;
  for (const StampedPose& p : estimate) {
    const auto at = pose_at(truth, p.time);
    if (!at) continue;
    const SE2d expected = T_map_truth * *at;
    const Eigen::Vector2d d = p.T_map_base.raw().translation() - expected.translation();
    const double heading_deg =
        (expected.rotation().inverse() * p.T_map_base.raw().rotation()).angle().degrees();
    e.x_m += d.x() * d.x();
    e.y_m += d.y() * d.y();
    e.heading_deg += heading_deg * heading_deg;
    e.end_m = d.norm();
    e.worst_m = std::max(e.worst_m, e.end_m);
    e.times_s.push_back(to_seconds(p.time - estimate.front().time));
    e.distances_m.push_back(e.end_m);
  }
  const auto n = static_cast<double>(e.times_s.size());
  for (double* v : {&e.x_m, &e.y_m, &e.heading_deg}) *v = std::sqrt(*v / n);
  return e;
}

}  // namespace wayfare::examples
