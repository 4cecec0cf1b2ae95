#include "match/lines/candidates.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace wayfare::lines {

void Beams::update_bearings(const LaserScan& scan) {
  const std::size_t n = scan.ranges_m.size();
  if (scan.bearings.empty() && n == cos_bearing.size() &&
      first_rad_ == scan.first_bearing.radians() && step_rad_ == scan.bearing_step.radians())
    return;
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();  // equal to no bearing
  first_rad_ = scan.bearings.empty() ? scan.first_bearing.radians() : kNone;
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
  float high = std::min(scan.max_range_m, static_cast<float>(max_range_m));
  if (n == 0 || !std::isfinite(scan.bearing(n - 1).radians())) high = 0.0F;
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

namespace {

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

struct Run {
  std::size_t begin, end;  // the last point is end − 1
};

/// Splits the runs of the stack `open`.
void split_runs(const Beams& beams, const WallOptions& options, std::vector<Run>& open,
                std::vector<Segment>& segments) {
  const double noise = std::hypot(options.range_noise_m, options.flatness_m);
  const auto min_points = static_cast<std::size_t>(std::max(options.min_segment_points, 2));
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

constexpr double kLeastOffset_m = 0.12;
/// Surfaces farther apart are separate: door recesses are slightly deeper.
constexpr double kLayer_m = 0.03;
constexpr double kNear_rad = 25.0 * std::numbers::pi / 180.0;

/// A line's direction within ±90° of `about`.
double along(double direction_rad, double about_rad) {
  return about_rad + std::remainder(direction_rad - about_rad, std::numbers::pi);
}

bool far_from(double direction_rad, std::optional<Angle> near) {
  return near &&
         std::abs(std::remainder(direction_rad - near->radians(), std::numbers::pi)) > kNear_rad;
}

/// Offset of the window of width `window_m` with the greatest weight, on each side.
class Offsets {
 public:
  void add(double offset_m, double weight) { entries_.push_back({offset_m, weight}); }

  struct Best {
    double offset_m = 0.0, weight = 0.0;
  };
  [[nodiscard]] std::array<Best, 2> best(double window_m) {
    std::sort(entries_.begin(), entries_.end(),
              [](const Entry& a, const Entry& b) { return a.offset_m < b.offset_m; });
    std::array<Best, 2> found;
    std::size_t first = 0;
    double weight = 0.0, moment = 0.0;
    for (const Entry& entry : entries_) {
      weight += entry.weight;
      moment += entry.weight * entry.offset_m;
      while (entry.offset_m - entries_[first].offset_m > window_m) {
        weight -= entries_[first].weight;
        moment -= entries_[first].weight * entries_[first].offset_m;
        ++first;
      }
      Best& side = found[entry.offset_m > 0.0 ? 0 : 1];
      if (weight > side.weight) side = {moment / weight, weight};
    }
    return found;
  }
  void clear() { entries_.clear(); }

 private:
  struct Entry {
    double offset_m, weight;
  };
  std::vector<Entry> entries_;
};

Candidate candidate_of(double direction_rad, const std::array<Offsets::Best, 2>& best, double least,
                       const WallOptions& options) {
  Candidate c;
  c.lines.direction_rad = direction_rad;
  for (std::size_t k = 0; k < 2; ++k) {
    c.lines.offset_m[k] = best[k].offset_m;
    c.lines.present[k] = best[k].weight >= least;
  }
  const double width = best[0].offset_m - best[1].offset_m;
  if (c.lines.present[0] && c.lines.present[1] &&
      (width < options.min_width_m || width > options.max_width_m)) {
    c.lines.present[best[0].weight > best[1].weight ? 1 : 0] = false;
  }
  for (std::size_t k = 0; k < 2; ++k) c.support_m += c.lines.present[k] ? best[k].weight : 0.0;
  return c;
}

/// The walls along a direction: of the segments parallel to it, those whose offsets agree.
Candidate agreeing_along(double direction_rad, std::span<const Segment> segments, double window_m,
                         Offsets& offsets, const WallOptions& options) {
  const double parallel = std::cos(options.parallel_within.radians());
  const double ux = std::cos(direction_rad), uy = std::sin(direction_rad);
  offsets.clear();
  for (const Segment& s : segments) {
    if (std::abs(s.ux * ux + s.uy * uy) < parallel) continue;
    const double offset = s.y_m * ux - s.x_m * uy;
    if (std::abs(offset) > kLeastOffset_m) offsets.add(offset, s.weight_m);
  }
  return candidate_of(direction_rad, offsets.best(window_m), options.min_segment_m, options);
}

/// Total least squares on the segments of both walls, with uniform density along each.
double direction_of(const Candidate& c, std::span<const Segment> segments, double window_m) {
  const double ux = std::cos(c.lines.direction_rad), uy = std::sin(c.lines.direction_rad);
  double tt = 0.0, td = 0.0;
  for (std::size_t k = 0; k < 2; ++k) {
    if (!c.lines.present[k]) continue;
    double n = 0.0, t = 0.0, d = 0.0, stt = 0.0, std = 0.0;
    for (const Segment& s : segments) {
      const double across = s.y_m * ux - s.x_m * uy - c.lines.offset_m[k];
      const double su = s.ux * ux + s.uy * uy, sn = s.uy * ux - s.ux * uy;
      const double along = s.x_m * ux + s.y_m * uy, l = s.length_m, own = l * l * l / 12.0;
      if (std::abs(across) + 0.5 * l * std::abs(sn) > window_m) continue;
      n += l, t += l * along, d += l * across;
      stt += l * along * along + own * su * su;
      std += l * along * across + own * su * sn;
    }
    if (n > 0.0) tt += stt - t * t / n, td += std - t * d / n;
  }
  return c.lines.direction_rad + (tt > 0.0 ? td / tt : 0.0);
}

}  // namespace

std::vector<Segment> split(const Beams& beams, const WallOptions& options) {
  std::vector<Segment> segments;
  std::vector<Run> open;
  segments.reserve(64);
  open.reserve(64);
  const std::size_t n = beams.x_m.size();
  const double gap2 = options.break_m * options.break_m;
  std::size_t begin = 0;
  for (std::size_t i = 1; i <= n; ++i) {
    if (i < n) {
      const double dx = beams.x_m[i] - beams.x_m[i - 1], dy = beams.y_m[i] - beams.y_m[i - 1];
      if (dx * dx + dy * dy <= gap2) continue;
    }
    open.push_back({begin, i});
    split_runs(beams, options, open, segments);
    begin = i;
  }
  return segments;
}

std::vector<Candidate> agreed_walls(std::span<const Segment> segments, std::optional<Angle> near,
                                    const WallOptions& options) {
  std::vector<const Segment*> longest;
  for (const Segment& s : segments)
    if (!far_from(std::atan2(s.uy, s.ux), near)) longest.push_back(&s);
  const auto tried = std::min<std::size_t>(longest.size(), 8);
  std::partial_sort(longest.begin(), longest.begin() + static_cast<std::ptrdiff_t>(tried),
                    longest.end(),
                    [](const Segment* a, const Segment* b) { return a->length_m > b->length_m; });
  Offsets offsets;
  std::vector<Candidate> all;
  for (std::size_t i = 0; i < tried; ++i) {
    const double direction = std::atan2(longest[i]->uy, longest[i]->ux);
    all.push_back(agreeing_along(direction, segments, kLayer_m, offsets, options));
  }
  std::stable_sort(all.begin(), all.end(), [](const Candidate& a, const Candidate& b) {
    return a.support_m > b.support_m;
  });
  std::vector<Candidate> best;
  for (const Candidate& c : all) {
    if (c.support_m < options.min_support_m || best.size() == 3) break;
    if (!best.empty() && c.support_m < 0.3 * best.front().support_m) break;
    const bool known = std::any_of(best.begin(), best.end(), [&](const Candidate& other) {
      return std::abs(std::remainder(c.lines.direction_rad - other.lines.direction_rad,
                                     std::numbers::pi)) < kNear_rad;
    });
    if (known) continue;
    best.push_back(c);
  }
  for (Candidate& c : best) {
    // Recessed doors are parallel to the wall: they do not bias the direction, and once it is known
    // their offset differs.
    const double direction = direction_of(c, segments, 0.75 * kLayer_m);
    c = agreeing_along(direction, segments, kLayer_m, offsets, options);
    c.lines.direction_rad = along(direction_of(c, segments, 0.75 * kLayer_m), 0.0);
  }
  return best;
}

std::vector<Candidate> correlated_walls(const Beams& beams, std::optional<Angle> near,
                                        const WallOptions& options) {
  constexpr double kStep_rad = std::numbers::pi / 180.0;
  constexpr double kCell_m = 0.05;
  constexpr double kMostCells = 1e5;
  const double cells = std::min(options.max_width_m, options.max_range_m + kCell_m) / kCell_m;
  const auto half = static_cast<std::ptrdiff_t>(cells > 0 ? std::min(cells, kMostCells) : 0.0);
  const auto most = static_cast<double>(half);
  std::vector<double> count(static_cast<std::size_t>(2 * half + 2));
  Candidate best;
  for (int h = -90; h < 90; ++h) {
    const double direction = h * kStep_rad;
    if (far_from(direction, near)) continue;
    std::fill(count.begin(), count.end(), 0.0);
    const double ux = std::cos(direction), uy = std::sin(direction);
    for (std::size_t i = 0; i < beams.x_m.size(); ++i) {
      const double offset = beams.y_m[i] * ux - beams.x_m[i] * uy;
      const double cell = std::floor(offset / kCell_m);
      if (!(std::abs(cell) <= most) || std::abs(offset) < kLeastOffset_m) continue;
      count[static_cast<std::size_t>(static_cast<std::ptrdiff_t>(cell) + half)] += 1.0;
    }
    std::array<Offsets::Best, 2> sides;
    for (std::ptrdiff_t c = 0; c <= 2 * half; ++c) {
      const auto i = static_cast<std::size_t>(c);
      const double weight = count[i] + count[i + 1];
      const double offset = static_cast<double>(c - half + 1) * kCell_m;
      Offsets::Best& side = sides[offset > 0.0 ? 0 : 1];
      if (weight > side.weight) side = {offset, weight};
    }
    const Candidate c = candidate_of(direction, sides, options.min_beams, options);
    if (c.support_m > best.support_m) best = c;
  }
  if (best.support_m < 2.0 * options.min_beams) return {};
  return {best};
}

std::optional<Guess> wall_across(std::span<const Segment> segments, double direction_rad) {
  constexpr double kLeastLength_m = 0.6;
  const double ux = std::cos(direction_rad), uy = std::sin(direction_rad);
  const Segment* best = nullptr;
  for (const Segment& s : segments) {
    const bool across = std::abs(s.ux * ux + s.uy * uy) < 0.2;
    const bool ahead = s.x_m * ux + s.y_m * uy > kLeastOffset_m;
    if (!across || !ahead || s.length_m < kLeastLength_m) continue;
    if (best == nullptr || s.length_m > best->length_m) best = &s;
  }
  if (best == nullptr) return {};
  // With the direction 90° clockwise from ahead the wall is on the left.
  const double direction =
      along(std::atan2(best->uy, best->ux), direction_rad - 0.5 * std::numbers::pi);
  const double offset = best->y_m * std::cos(direction) - best->x_m * std::sin(direction);
  return Guess{direction, {offset, 0.0}, {true, false}};
}

}  // namespace wayfare::lines
