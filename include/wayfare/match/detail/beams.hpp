#pragma once

#include <vector>

#include <wayfare/sensors/scans.hpp>

namespace wayfare::lines {

/// A scan as arrays, one entry per beam; a beam without a return within max_range_m has range 0.
struct Beams {
  std::vector<double> cos_bearing, sin_bearing, range_m;
  /// Points of the beams that returned, in order.
  std::vector<double> x_m, y_m;

  void load(const LaserScan& scan, double max_range_m);

 private:
  void update_bearings(const LaserScan& scan);
  double first_rad_ = 0.0, step_rad_ = 0.0;
};

}  // namespace wayfare::lines
