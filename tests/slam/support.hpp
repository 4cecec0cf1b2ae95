#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include <wayfare/eval/trajectory_error.hpp>
#include <wayfare/sensors/scans.hpp>

#include "sim/support.hpp"

namespace wayfare {

/// Of the positions, after rigid alignment.
inline double rmse_m(const Trajectory& estimate, const Trajectory& truth) {
  return eval::absolute_error(estimate, truth).translation_m.rmse;
}

/// An empty room of 6 m × 4 m seen from (x, y) by a laser of 360 beams all round.
inline LaserScan room_scan(double time_s, double x, double y) {
  LaserScan scan{
      LogTime::from_seconds(time_s), Angle::degrees(-180), Angle::degrees(1), 0.05F, 20.0F, {}};
  for (std::size_t i = 0; i < 360; ++i) {
    const double b = scan.first_bearing.radians() + static_cast<double>(i) * std::numbers::pi / 180;
    const double tx = ((std::cos(b) > 0 ? 6.0 : 0.0) - x) / std::cos(b);
    const double ty = ((std::sin(b) > 0 ? 4.0 : 0.0) - y) / std::sin(b);
    scan.ranges_m.push_back(static_cast<float>(std::min(std::abs(tx), std::abs(ty))));
  }
  return scan;
}

}  // namespace wayfare
