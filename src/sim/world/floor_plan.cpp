#include <wayfare/sim/floor_plan.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <deque>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/core/contract.hpp>

namespace wayfare::sim {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kFarthest_m = 1e5;
constexpr double kShortest_m = 1e-6;
// Extends a wall slightly past its ends, so that no ray passes between two that join.
constexpr double kJoint_m = 1e-9;

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

// Distance along the ray to the wall, infinity without intersection: o + t d = a + u (b - a).
double distance_to(const Segment& s, const Eigen::Vector2d& origin, const Eigen::Vector2d& d) {
  const Eigen::Vector2d along = s.b_m - s.a_m;
  const double det = cross(d, along);
  if (det == 0.0) return kInfinity;
  const Eigen::Vector2d to_a = s.a_m - origin;
  const double t = cross(to_a, along) / det;
  const double u = cross(to_a, d) / det;
  const double slack = kJoint_m / along.norm();
  return t >= 0.0 && u >= -slack && u <= 1.0 + slack ? t : kInfinity;
}

double distance_to(const Segment& s, const Eigen::Vector2d& p) {
  const Eigen::Vector2d along = s.b_m - s.a_m;
  const double u = std::clamp((p - s.a_m).dot(along) / along.squaredNorm(), 0.0, 1.0);
  return (p - s.a_m - u * along).norm();
}

// The part [t_in, t_out] of the ray between two parallel lines; empty if t_in > t_out.
void clip_slab(double origin, double d, double low, double high, double& t_in, double& t_out) {
  if (d == 0.0) {
    if (origin < low || origin > high) t_out = -kInfinity;
    return;
  }
  const double t0 = (low - origin) / d;
  const double t1 = (high - origin) / d;
  t_in = std::max(t_in, std::min(t0, t1));
  t_out = std::min(t_out, std::max(t0, t1));
}

bool is_sound(const Segment& s) {
  return s.a_m.allFinite() && s.b_m.allFinite() &&
         std::max(s.a_m.cwiseAbs().maxCoeff(), s.b_m.cwiseAbs().maxCoeff()) <= kFarthest_m &&
         (s.b_m - s.a_m).norm() >= kShortest_m;
}

// Straight runs of cell borders along one axis. `wall_at(line, k)` gives the side of grid line
// `line` with wall at position k: +1, -1 or 0 for none or both.
template <class WallAt, class Emit>
void trace_runs(int lines, int length, const WallAt& wall_at, const Emit& emit) {
  for (int line = 0; line <= lines; ++line) {
    int start = 0;
    for (int k = 1; k <= length; ++k) {
      const int side = wall_at(line, start);
      if (k < length && wall_at(line, k) == side) continue;
      if (side != 0) emit(line, start, k);
      start = k;
    }
  }
}

double measure(double true_range_m, const Lidar2dParams& params, Rng& rng) {
  // Both numbers are drawn for every beam, so that one beam does not shift the noise of others.
  const double noise_m = params.range_noise_m * rng.normal();
  const bool missed = rng.uniform() < params.missed_return;
  if (missed || !(true_range_m < params.max_range_m)) return params.max_range_m;
  double range_m = std::max(0.0, true_range_m + noise_m);
  if (params.resolution_m > 0.0)
    range_m = std::round(range_m / params.resolution_m) * params.resolution_m;
  return std::min(range_m, params.max_range_m);
}

}  // namespace

Result<FloorPlan> FloorPlan::from_segments(std::vector<Segment> segments) {
  if (segments.empty()) return Error{ErrorCode::invalid, "a floor plan needs at least one wall"};
  for (std::size_t i = 0; i < segments.size(); ++i) {
    if (is_sound(segments[i])) continue;
    return Error{ErrorCode::invalid, "wall " + std::to_string(i) +
                                         " is not finite, beyond 100 km or shorter than 1 um"};
  }
  FloorPlan plan;
  plan.segments_ = std::move(segments);
  plan.build_index();
  return plan;
}

Result<FloorPlan> FloorPlan::from_cells(const CellMask& mask) {
  const bool sound = mask.width > 0 && mask.height > 0 && mask.cell_m > 0.0 &&
                     mask.solid.size() == mask.index(0, mask.height);
  if (!sound) {
    return Error{ErrorCode::invalid,
                 "a cell mask needs a positive cell size and width x height values"};
  }
  std::vector<Segment> walls;
  const auto corner = [&](int column, int row) {
    return Eigen::Vector2d(column * mask.cell_m, (mask.height - row) * mask.cell_m);
  };
  trace_runs(
      mask.height, mask.width,
      [&](int row, int k) { return int{mask.is_solid(k, row)} - int{mask.is_solid(k, row - 1)}; },
      [&](int row, int from, int to) {
        walls.push_back({corner(from, row), corner(to, row)});
      });
  trace_runs(
      mask.width, mask.height,
      [&](int col, int k) { return int{mask.is_solid(col, k)} - int{mask.is_solid(col - 1, k)}; },
      [&](int col, int from, int to) {
        walls.push_back({corner(col, from), corner(col, to)});
      });
  return from_segments(std::move(walls));
}

void FloorPlan::build_index() {
  lower_m_ = upper_m_ = segments_.front().a_m;
  for (const Segment& s : segments_) {
    lower_m_ = lower_m_.cwiseMin(s.a_m).cwiseMin(s.b_m);
    upper_m_ = upper_m_.cwiseMax(s.a_m).cwiseMax(s.b_m);
  }
  const Eigen::Vector2d extent = upper_m_ - lower_m_;
  cell_m_ = std::max(0.5, extent.maxCoeff() / 512.0);
  columns_ = 1 + static_cast<int>(extent.x() / cell_m_);
  rows_ = 1 + static_cast<int>(extent.y() / cell_m_);
  const std::size_t cells = static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_);

  first_.assign(cells + 1, 0);
  for (const Segment& s : segments_) for_cells_of(s, [&](std::size_t c) { ++first_[c + 1]; });
  for (std::size_t c = 0; c < cells; ++c) first_[c + 1] += first_[c];
  members_.resize(first_.back());
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  for (std::size_t i = 0; i < segments_.size(); ++i) {
    for_cells_of(segments_[i],
                 [&](std::size_t c) { members_[next[c]++] = static_cast<std::uint32_t>(i); });
  }
}

int FloorPlan::column_of(double x_m) const {
  return static_cast<int>(std::clamp((x_m - lower_m_.x()) / cell_m_, 0.0, columns_ - 1.0));
}

int FloorPlan::row_of(double y_m) const {
  return static_cast<int>(std::clamp((y_m - lower_m_.y()) / cell_m_, 0.0, rows_ - 1.0));
}

// Every cell touched by the wall, with a margin for rounding at cell borders.
template <class Visit>
void FloorPlan::for_cells_of(const Segment& s, Visit&& visit) const {
  const double margin = 1e-6 * cell_m_;
  const Eigen::Vector2d low = s.a_m.cwiseMin(s.b_m), high = s.a_m.cwiseMax(s.b_m);
  const Eigen::Vector2d along = s.b_m - s.a_m;
  for (int row = row_of(low.y() - margin); row <= row_of(high.y() + margin); ++row) {
    for (int col = column_of(low.x() - margin); col <= column_of(high.x() + margin); ++col) {
      const Eigen::Vector2d from = lower_m_ + cell_m_ * Eigen::Vector2d(col, row);
      double t_in = 0.0, t_out = 1.0;
      const double reach = cell_m_ + margin;
      clip_slab(s.a_m.x(), along.x(), from.x() - margin, from.x() + reach, t_in, t_out);
      clip_slab(s.a_m.y(), along.y(), from.y() - margin, from.y() + reach, t_in, t_out);
      if (t_in > t_out) continue;
      visit(static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
            static_cast<std::size_t>(col));
    }
  }
}

std::span<const std::uint32_t> FloorPlan::cell(int column, int row) const {
  const std::size_t c = static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
                        static_cast<std::size_t>(column);
  return std::span(members_).subspan(first_[c], first_[c + 1] - first_[c]);
}

double FloorPlan::cast(const Eigen::Vector2d& origin_m, const Eigen::Vector2d& direction,
                       double max_range_m) const {
  if (!origin_m.allFinite() || !direction.allFinite()) return kInfinity;
  double t_in = 0.0, t_out = max_range_m;
  for (int axis = 0; axis < 2; ++axis) {
    clip_slab(origin_m[axis], direction[axis], lower_m_[axis] - kJoint_m, upper_m_[axis] + kJoint_m,
              t_in, t_out);
  }
  if (!(t_in <= t_out)) return kInfinity;

  // Amanatides and Woo 1987: step to the neighbour that the ray enters first.
  const Eigen::Vector2d entry = origin_m + t_in * direction;
  if (!entry.allFinite()) return kInfinity;
  int at[2] = {column_of(entry.x()), row_of(entry.y())};
  const int size[2] = {columns_, rows_};
  int step[2];
  double t_next[2], t_cell[2];
  for (int axis = 0; axis < 2; ++axis) {
    const double d = direction[axis];
    step[axis] = d > 0.0 ? 1 : -1;
    t_cell[axis] = d == 0.0 ? kInfinity : cell_m_ / std::abs(d);
    const double border = lower_m_[axis] + cell_m_ * (at[axis] + (d > 0.0 ? 1 : 0));
    t_next[axis] = d == 0.0 ? kInfinity : (border - origin_m[axis]) / d;
  }
  double nearest = kInfinity;
  while (true) {
    for (const std::uint32_t i : cell(at[0], at[1]))
      nearest = std::min(nearest, distance_to(segments_[i], origin_m, direction));
    const int axis = t_next[0] <= t_next[1] ? 0 : 1;
    if (nearest <= t_next[axis] || t_next[axis] > t_out) break;
    at[axis] += step[axis];
    if (at[axis] < 0 || at[axis] >= size[axis]) break;
    t_next[axis] += t_cell[axis];
  }
  return nearest <= max_range_m ? nearest : kInfinity;
}

bool FloorPlan::blocks(const Eigen::Vector2d& from_m, const Eigen::Vector2d& to_m) const {
  const double distance = (to_m - from_m).norm();
  if (!(distance > 0.0)) return false;
  return cast(from_m, (to_m - from_m) / distance, distance) < kInfinity;
}

double FloorPlan::clearance(const Eigen::Vector2d& point_m, double max_m) const {
  if (!point_m.allFinite() || !(max_m >= 0.0)) return kInfinity;
  double nearest = kInfinity;
  for (int row = row_of(point_m.y() - max_m); row <= row_of(point_m.y() + max_m); ++row) {
    for (int col = column_of(point_m.x() - max_m); col <= column_of(point_m.x() + max_m); ++col) {
      for (const std::uint32_t i : cell(col, row))
        nearest = std::min(nearest, distance_to(segments_[i], point_m));
    }
  }
  return nearest <= max_m ? nearest : kInfinity;
}

std::optional<Eigen::Vector2d> find_leak(const FloorPlan& plan, const Eigen::Vector2d& inside_m,
                                         double step_m) {
  WAYFARE_EXPECTS(step_m > 0.0, "the step of the search is positive");
  const Eigen::Vector2d lower = plan.lower_corner_m(), extent = plan.upper_corner_m() - lower;
  const double step = std::max(step_m, extent.maxCoeff() / 4096.0);
  const auto outside = [&](const Eigen::Vector2d& p) {
    return !((p - lower).minCoeff() > 0.0 && (plan.upper_corner_m() - p).minCoeff() > 0.0);
  };
  if (outside(inside_m)) return inside_m;  // NaN too

  // The lattice passes through `inside_m`, so that rounding starts no step on a wall.
  const Eigen::Array2i below = ((inside_m - lower) / step).array().floor().cast<int>();
  const Eigen::Array2i size =
      below + 2 + ((plan.upper_corner_m() - inside_m) / step).array().ceil().cast<int>();
  std::vector<bool> seen(static_cast<std::size_t>(size.x()) * static_cast<std::size_t>(size.y()));
  const auto index = [&](const Eigen::Array2i& c) {
    return static_cast<std::size_t>(c.y()) * static_cast<std::size_t>(size.x()) +
           static_cast<std::size_t>(c.x());
  };
  const auto point = [&](const Eigen::Array2i& c) {
    return Eigen::Vector2d(inside_m + step * (c - below).cast<double>().matrix());
  };
  std::deque<Eigen::Array2i> front{below};
  seen[index(below)] = true;
  while (!front.empty()) {
    const Eigen::Array2i here = front.front();
    front.pop_front();
    for (const auto& [dx, dy] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
      const Eigen::Array2i next = here + Eigen::Array2i(dx, dy);
      const Eigen::Vector2d p = point(next);
      const bool leaves = outside(p);
      if (!leaves && seen[index(next)]) continue;
      if (plan.blocks(point(here), p)) continue;
      if (leaves) return p;
      seen[index(next)] = true;
      front.push_back(next);
    }
  }
  return std::nullopt;
}

Lidar2dParams full_circle(std::size_t beams) {
  WAYFARE_EXPECTS(beams > 0, "a lidar has beams");
  Lidar2dParams params;
  params.beams = beams;
  params.first_bearing = Angle::degrees(-180.0);
  params.bearing_step = Angle::degrees(360.0 / static_cast<double>(beams));
  return params;
}

LaserScan simulate_scan(const FloorPlan& plan, const std::function<SE2d(LogTime)>& T_plan_laser,
                        LogTime time, const Lidar2dParams& params, Rng& rng) {
  LaserScan scan{time + std::max(params.sweep, Duration::zero()) / 2,
                 params.first_bearing,
                 params.bearing_step,
                 static_cast<float>(params.min_range_m),
                 static_cast<float>(params.max_range_m),
                 {}};
  scan.ranges_m.resize(params.beams);
  const auto steps = static_cast<std::int64_t>(std::max<std::size_t>(params.beams, 2) - 1);
  scan.time_increment = std::max(params.sweep, Duration::zero()) / steps;
  SE2d pose = T_plan_laser(time);
  for (std::size_t i = 0; i < params.beams; ++i) {
    if (scan.is_sweep()) pose = T_plan_laser(scan.beam_time(i));
    const double bearing = scan.bearing(i).radians();
    const Eigen::Vector2d beam =
        pose.rotation() * Eigen::Vector2d(std::cos(bearing), std::sin(bearing));
    const double range_m = plan.cast(pose.translation(), beam, params.max_range_m);
    scan.ranges_m[i] = static_cast<float>(measure(range_m, params, rng));
  }
  return scan;
}

}  // namespace wayfare::sim
