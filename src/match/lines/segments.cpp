#include "match/lines/segments.hpp"

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

namespace {

/// Line through the mean along the direction of greatest scatter: no singular direction.
Segment fit(const Beams& b, std::size_t begin, std::size_t end, double noise_m) {
  const double n = static_cast<double>(end - begin);
  const double x0 = b.x_m[begin], y0 = b.y_m[begin];
  double sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0, syy = 0.0;
  for (std::size_t i = begin; i < end; ++i) {
    const double x = b.x_m[i] - x0, y = b.y_m[i] - y0;
    sx += x, sy += y, sxx += x * x, sxy += x * y, syy += y * y;
  }
  sxx -= sx * sx / n, sxy -= sx * sy / n, syy -= sy * sy / n;
  const double angle = 0.5 * std::atan2(2.0 * sxy, sxx - syy);
  Segment s;
  s.x_m = x0 + sx / n;
  s.y_m = y0 + sy / n;
  s.ux = std::cos(angle);
  s.uy = std::sin(angle);
  const double dx = b.x_m[end - 1] - x0, dy = b.y_m[end - 1] - y0;
  s.length_m = std::sqrt(dx * dx + dy * dy);
  const double half = 0.5 * (sxx - syy);
  const double across2 = 0.5 * (sxx + syy) - std::sqrt(half * half + sxy * sxy);
  s.weight_m = s.length_m / std::max(1.0, across2 / (4.0 * n * noise_m * noise_m));
  return s;
}

struct Farthest {
  std::size_t index;
  double distance_m, chord_m;
};
/// Farthest point from the chord between the ends of a run; of a closed run, from its first point.
Farthest farthest(const Beams& b, std::size_t begin, std::size_t end) {
  const double x0 = b.x_m[begin], y0 = b.y_m[begin];
  const double dx = b.x_m[end - 1] - x0, dy = b.y_m[end - 1] - y0;
  const double chord = std::sqrt(dx * dx + dy * dy);
  const double nx = chord > 0.0 ? -dy / chord : 0.0, ny = chord > 0.0 ? dx / chord : 1.0;
  std::size_t index = begin;
  double distance = -1.0;
  for (std::size_t i = begin; i < end; ++i) {
    const double d = std::abs((b.x_m[i] - x0) * nx + (b.y_m[i] - y0) * ny);
    index = d > distance ? i : index;
    distance = d > distance ? d : distance;
  }
  return {index, distance, chord};
}

void split_run(const Beams& beams, const WallOptions& options, std::size_t begin, std::size_t end,
               std::vector<Segment>& segments) {
  struct Run {
    std::size_t begin, end;  // the last point is end − 1
  };
  const double noise = std::hypot(options.range_noise_m, options.flatness_m);
  const auto min_points = static_cast<std::size_t>(std::max(options.min_segment_points, 2));
  std::vector<Run> open{{begin, end}};
  while (!open.empty()) {
    const Run r = open.back();
    open.pop_back();
    if (r.end - r.begin < min_points) continue;
    const Farthest f = farthest(beams, r.begin, r.end);
    if (f.distance_m > options.split_m) {
      // An end can be the farthest only in a closed run; it is separated.
      const std::size_t at = std::clamp(f.index, r.begin + 1, r.end - 1);
      open.push_back({at, r.end});
      open.push_back({r.begin, at + (at + 1 < r.end ? 1 : 0)});
    } else if (f.chord_m >= options.min_segment_m) {
      segments.push_back(fit(beams, r.begin, r.end, noise));
    }
  }
}

}  // namespace

std::vector<Segment> split(const Beams& beams, const WallOptions& options) {
  std::vector<Segment> segments;
  const std::size_t n = beams.x_m.size();
  const double gap2 = options.break_m * options.break_m;
  std::size_t begin = 0;
  for (std::size_t i = 1; i <= n; ++i) {
    if (i < n) {
      const double dx = beams.x_m[i] - beams.x_m[i - 1], dy = beams.y_m[i] - beams.y_m[i - 1];
      if (dx * dx + dy * dy <= gap2) continue;
    }
    split_run(beams, options, begin, i, segments);
    begin = i;
  }
  return segments;
}

}  // namespace wayfare::lines
