#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/time.hpp>

namespace wayfare {

/// One sweep of a planar range finder. Beam i points along `first_bearing + i * bearing_step` in
/// the laser's frame (counter-clockwise positive, 0 along x).
struct LaserScan {
  LogTime time;
  Angle first_bearing;
  Angle bearing_step;
  /// A range outside [min_range_m, max_range_m), or NaN, is a beam that did not return.
  float min_range_m = 0.0F;
  float max_range_m = 0.0F;
  std::vector<float> ranges_m;

  [[nodiscard]] bool returned(std::size_t beam) const {
    const float r = ranges_m[beam];
    return r >= min_range_m && r < max_range_m;  // false for NaN
  }
  [[nodiscard]] Angle bearing(std::size_t beam) const {
    return first_bearing + bearing_step * static_cast<double>(beam);
  }
};

}  // namespace wayfare
