#include "thin_recording.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace wayfare::examples {
namespace {

void thin(LaserScan& scan, const Thinning& t) {
  const double half = Angle::degrees(0.5 * t.field_of_view_deg).radians();
  std::vector<float> kept;
  std::size_t first = scan.ranges_m.size();
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    if (t.field_of_view_deg > 0 && std::abs(scan.bearing(i).radians()) > half) continue;
    first = std::min(first, i);
    if ((i - first) % t.beams == 0) kept.push_back(scan.ranges_m[i]);
  }
  if (!kept.empty()) scan.first_bearing = scan.bearing(first);
  scan.bearing_step = scan.bearing_step * static_cast<double>(t.beams);
  scan.ranges_m = std::move(kept);
  if (t.max_range_m > 0)
    scan.max_range_m = std::min(scan.max_range_m, static_cast<float>(t.max_range_m));
}

}  // namespace

void add_thinning(CommandLine& app, Thinning& t) {
  app.add_option("--every", t.every, "keep one scan of this number").range(1, 1000000);
  app.add_option("--beams", t.beams, "keep one beam of this number").range(1, 100000);
  app.add_option("--max-range", t.max_range_m, "farther ranges become missing returns, m")
      .range(0.0, 10000.0);
  app.add_option("--field-of-view", t.field_of_view_deg,
                 "of the beams to keep, symmetric about ahead, deg")
      .range(0.0, 360.0);
}

void thin(Recording& recording, const Thinning& t) {
  std::vector<LaserScan> kept;
  for (std::size_t i = 0; i < recording.scans.size(); i += t.every) {
    kept.push_back(std::move(recording.scans[i]));
    thin(kept.back(), t);
  }
  recording.scans = std::move(kept);
}

}  // namespace wayfare::examples
