#include <algorithm>
#include <cmath>

#include <wayfare/match/lines.hpp>

namespace wayfare {
namespace {

struct Hit {
  double range_m, along_m, across_m;  ///< in the axes of the corridor; range 0: no return
};

Hit hit_of(const lines::Beams& beams, std::size_t i, double c, double s) {
  const double r = beams.range_m[i], x = r * beams.cos_bearing[i], y = r * beams.sin_bearing[i];
  return {r, c * x + s * y, c * y - s * x};
}

/// Whether a hit is on the wall at an offset.
bool is_on(const Hit& hit, const std::optional<Wall>& wall) {
  constexpr double kOn_m = 0.1;
  return wall && std::abs(hit.across_m - wall->offset_m) < kOn_m;
}

}  // namespace

std::vector<WallEdge> WallDetector::edges(const LaserScan& scan, const CorridorWalls& walls,
                                          double jump_m) {
  constexpr double kCoarsest_m = 0.15;
  beams_.load(scan, options_.max_range_m);
  std::vector<WallEdge> found;
  const double step = std::abs(scan.bearing_step.radians());
  const double c = std::cos(walls.direction.radians()), s = std::sin(walls.direction.radians());
  const auto is_beyond = [&](std::size_t i, const Hit& near) {
    const double r = beams_.range_m[i];
    return r == 0.0 || r - near.range_m >= jump_m;
  };
  // Two beams on the wall and two beyond it: a single beam may be lost.
  for (std::size_t i = 1; i + 2 < beams_.range_m.size(); ++i) {
    const Hit before = hit_of(beams_, i, c, s), after = hit_of(beams_, i + 1, c, s);
    const bool a_near =
        before.range_m > 0.0 && is_beyond(i + 1, before) && is_beyond(i + 2, before);
    const bool b_near = after.range_m > 0.0 && is_beyond(i, after) && is_beyond(i - 1, after);
    if (a_near == b_near) continue;
    const Hit& near = a_near ? before : after;
    const Hit next = hit_of(beams_, a_near ? i - 1 : i + 2, c, s);
    const bool left = is_on(near, walls.left) && is_on(next, walls.left);
    const bool right = is_on(near, walls.right) && is_on(next, walls.right);
    if (!left && !right) continue;
    // Distance along the wall between neighbouring beams: the edge is somewhere in it.
    const double across = std::abs(near.across_m);
    const double spacing = near.range_m * near.range_m / across * step;
    if (!(spacing < kCoarsest_m)) continue;
    // Bearings increase along the corridor on its right, and decrease on its left.
    const bool ascending = right == (scan.bearing_step.radians() > 0.0);
    const bool gap_ahead = a_near == ascending;
    found.push_back({near.along_m + (gap_ahead ? 0.5 : -0.5) * spacing,
                     std::hypot(spacing / std::sqrt(12.0), options_.range_noise_m), left,
                     gap_ahead});
  }
  return found;
}

}  // namespace wayfare
