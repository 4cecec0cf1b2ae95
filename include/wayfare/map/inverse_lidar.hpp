#pragma once

// What one LiDAR scan says about the cells it passes: free up to the hit, occupied at it, nothing
// beyond (Zhang 2020, section 2.2).

#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/map/occupancy_grid.hpp>
#include <wayfare/map/ray.hpp>
#include <wayfare/measure/laser_scan.hpp>
#include <wayfare/measure/point_set.hpp>

namespace wayfare {

struct InverseLidarModel {
  /// Occupancy probability of a cell a beam passed through: lower forgets moved things sooner, and
  /// lets grazing beams eat walls.
  double p_free = 0.2;
  /// Of the cell the beam ended in.
  double p_hit = 0.9;
  /// A return farther than this, m, is no hit: the beam only frees cells up to this range.
  double max_usable_range_m = 60.0;
  /// What a beam that did not return frees, m; zero for sensors that also stay silent in front of
  /// glass or black paint.
  double free_range_without_return_m = 0.0;
};

/// How the cells in front of the hits are freed. A type with `static constexpr int
/// kMaxPassesPerCell`: how often one scan may free the same cell.
struct EveryBeam {
  static constexpr int kMaxPassesPerCell = 0x7fff;  ///< once for each beam that passes it
};
struct OncePerScan {
  static constexpr int kMaxPassesPerCell = 1;  ///< once, and hit once: near cells stay in measure
};

/// Scratch memory of insert_scan; keep one and pass it again. Holds no state between calls.
class ScanRaster {
 public:
  /// A scan larger than this (a side of 5800 cells, 290 m at 5 cm) is refused.
  static constexpr std::int64_t kMaxCells = std::int64_t{1} << 25;

  struct Ray {
    SubCellPoint end;
    bool hit = false;
  };

  std::vector<Ray>& rays() { return rays_; }

  template <class FreeSpace>
  Result<void> apply(OccupancyGrid& grid, const SubCellPoint& origin,
                     const InverseLidarModel& model);

 private:
  static constexpr std::uint16_t kHit = 0x8000;
  static constexpr int kCountMask = 0x7fff;

  [[nodiscard]] std::uint16_t& at(const Cell& c) {
    return counts_[static_cast<std::size_t>(c.y - box_.min.y) * stride_ +
                   static_cast<std::size_t>(c.x - box_.min.x)];
  }
  template <class FreeSpace>
  void count(const SubCellPoint& origin);
  void merge_into(OccupancyGrid& grid, int free_delta, int hit_delta);

  std::vector<Ray> rays_;
  CellBox box_;
  std::size_t stride_ = 0;
  std::vector<std::uint16_t> counts_;  // all zero between calls
  std::vector<std::int16_t> deltas_;
};

template <class FreeSpace>
void ScanRaster::count(const SubCellPoint& origin) {
  for (const Ray& ray : rays_) {
    for_each_cell_on_segment(origin, ray.end, [&](const Cell& c) {
      std::uint16_t& n = at(c);
      if (n < FreeSpace::kMaxPassesPerCell) ++n;
    });
  }
  // Hits come last and replace: no cell is both freed and hit by one scan.
  for (const Ray& ray : rays_) {
    if (!ray.hit) continue;
    std::uint16_t& n = at(ray.end.cell());
    const int hits = (n & kHit) != 0 ? n & kCountMask : 0;
    n = static_cast<std::uint16_t>(kHit | std::min(hits + 1, FreeSpace::kMaxPassesPerCell));
  }
}

inline void ScanRaster::merge_into(OccupancyGrid& grid, int free_delta, int hit_delta) {
  const int width = static_cast<int>(box_.width());
  deltas_.resize(stride_);
  for (int y = box_.min.y; y <= box_.max.y; ++y) {
    std::uint16_t* row = &at({box_.min.x, y});
    for (int i = 0; i < width; ++i) {
      const int n = row[i] & kCountMask;
      const int delta = n * ((row[i] & kHit) != 0 ? hit_delta : free_delta);
      deltas_[static_cast<std::size_t>(i)] =
          static_cast<std::int16_t>(std::clamp(delta, -32767, 32767));
    }
    std::fill(row, row + width, std::uint16_t{0});
    grid.update_row({box_.min.x, y}, std::span(deltas_).first(static_cast<std::size_t>(width)));
  }
}

template <class FreeSpace>
Result<void> ScanRaster::apply(OccupancyGrid& grid, const SubCellPoint& origin,
                               const InverseLidarModel& model) {
  if (rays_.empty()) return {};
  box_ = {origin.cell(), origin.cell()};
  for (const Ray& ray : rays_) box_.extend(ray.end.cell());
  if (box_.width() > kMaxCells / box_.height()) {
    return Error{ErrorCode::invalid, "the scan spans " + std::to_string(box_.width()) + " x " +
                                         std::to_string(box_.height()) +
                                         " cells, more than insert_scan takes"};
  }
  stride_ = static_cast<std::size_t>(box_.width());
  const std::size_t needed = stride_ * static_cast<std::size_t>(box_.height());
  if (counts_.size() < needed) counts_.resize(needed, 0);
  count<FreeSpace>(origin);
  merge_into(grid, LogOdds::from_probability(model.p_free).fixed,
             LogOdds::from_probability(model.p_hit).fixed);
  return {};
}

namespace detail {

[[nodiscard]] inline Result<void> check(const InverseLidarModel& m, const SE2d& pose) {
  const auto probability = [](double p) { return p > 0 && p < 1; };
  if (!probability(m.p_free) || !probability(m.p_hit) || !(m.max_usable_range_m > 0) ||
      !(m.free_range_without_return_m >= 0))
    return Error{ErrorCode::invalid,
                 "InverseLidarModel: probabilities must lie within (0, 1), "
                 "ranges must not be negative"};
  if (!pose.translation().allFinite() || !std::isfinite(pose.heading().radians()))
    return Error{ErrorCode::invalid, "insert_scan: the pose is not finite"};
  return {};
}

}  // namespace detail

/// Updates `grid` with one scan taken at `T_map_laser`. The grid is as it was when an Error comes
/// back (a pose that is not finite, a model out of range, a scan too large for the raster).
template <class FreeSpace = OncePerScan>
Result<void> insert_scan(OccupancyGrid& grid, const SE2d& T_map_laser, const LaserScan& scan,
                         const InverseLidarModel& model, ScanRaster& raster) {
  if (auto ok = detail::check(model, T_map_laser); !ok) return ok;
  auto& rays = raster.rays();
  rays.clear();
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const bool returned = scan.returned(i);
    const double range =
        returned ? static_cast<double>(scan.ranges_m[i]) : model.free_range_without_return_m;
    if (!(range > 0)) continue;
    const double bearing = scan.bearing(i).radians();
    const double length = std::min(range, model.max_usable_range_m);
    const Eigen::Vector2d end =
        T_map_laser * Eigen::Vector2d(length * std::cos(bearing), length * std::sin(bearing));
    rays.push_back({SubCellPoint::of(end, grid.resolution_m()),
                    returned && range <= model.max_usable_range_m});
  }
  return raster.apply<FreeSpace>(
      grid, SubCellPoint::of(T_map_laser.translation(), grid.resolution_m()), model);
}

/// The same for end points in the frame `T_map_points` leads from, with `origin` (the sensor, in
/// that frame) as the start of every ray. Points that are not finite are refused.
template <class FreeSpace = OncePerScan>
Result<void> insert_points(OccupancyGrid& grid, const SE2d& T_map_points, const PointSet& points,
                           const InverseLidarModel& model, ScanRaster& raster,
                           const Eigen::Vector2d& origin = Eigen::Vector2d::Zero()) {
  if (auto ok = detail::check(model, T_map_points); !ok) return ok;
  auto& rays = raster.rays();
  rays.clear();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector2d beam = points[i].cast<double>() - origin;
    const double range = beam.norm();
    if (!std::isfinite(range))
      return Error{ErrorCode::invalid,
                   "insert_points: point " + std::to_string(i) + " is not finite"};
    const double scale = std::min(1.0, model.max_usable_range_m / range);
    const Eigen::Vector2d end = T_map_points * Eigen::Vector2d(origin + scale * beam);
    rays.push_back({SubCellPoint::of(end, grid.resolution_m()), range <= model.max_usable_range_m});
  }
  return raster.apply<FreeSpace>(grid, SubCellPoint::of(T_map_points * origin, grid.resolution_m()),
                                 model);
}

}  // namespace wayfare
