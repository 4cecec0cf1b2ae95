#include "match/lines/beams.hpp"

#include <algorithm>
#include <cmath>

namespace wayfare::lines {

void Beams::update_bearings(const LaserScan& scan) {
  const std::size_t n = scan.ranges_m.size();
  if (n == cos_bearing.size() && first_rad_ == scan.first_bearing.radians() &&
      step_rad_ == scan.bearing_step.radians())
    return;
  first_rad_ = scan.first_bearing.radians();
  step_rad_ = scan.bearing_step.radians();
  cos_bearing.resize(n);
  sin_bearing.resize(n);
  range_m.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    cos_bearing[i] = std::cos(scan.bearing(i).radians());
    sin_bearing[i] = std::sin(scan.bearing(i).radians());
  }
}

void Beams::load(const LaserScan& scan, double max_range_m) {
  update_bearings(scan);
  const std::size_t n = range_m.size();
  x_m.resize(n);
  y_m.resize(n);
  const float low = std::max(scan.min_range_m, 1e-3F);
  const float high = std::min(scan.max_range_m, static_cast<float>(max_range_m));
  std::size_t kept = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const float r = scan.ranges_m[i];
    const bool good = r >= low && r < high;  // false for NaN
    range_m[i] = good ? static_cast<double>(r) : 0.0;
    x_m[kept] = range_m[i] * cos_bearing[i];
    y_m[kept] = range_m[i] * sin_bearing[i];
    kept += good ? 1 : 0;
  }
  x_m.resize(kept);
  y_m.resize(kept);
}

}  // namespace wayfare::lines
