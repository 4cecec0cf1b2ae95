#pragma once

// Inverse sensor model of a LiDAR: cells are free up to the hit, occupied at it and unchanged
// beyond (Zhang 2020, section 2.2).

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>

#include <wayfare/core/result.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/map/detail/scan_raster.hpp>
#include <wayfare/map/inverse_lidar_model.hpp>
#include <wayfare/map/occupancy_grid.hpp>
#include <wayfare/sensors/point_set.hpp>
#include <wayfare/sensors/scans.hpp>

namespace wayfare {

namespace detail {

[[nodiscard]] inline Result<void> check(const InverseLidarModel& m, const SE2d& pose) {
  const auto probability = [](double p) { return p > 0 && p < 1; };
  if (!probability(m.p_free) || !probability(m.p_hit) || !(m.max_usable_range_m > 0) ||
      !(m.free_range_without_return_m >= 0) || !(m.fill_gap.radians() >= 0))
    return Error{ErrorCode::invalid,
                 "InverseLidarModel: probabilities must lie within (0, 1), "
                 "ranges and the gap must not be negative"};
  if (!pose.translation().allFinite() || !std::isfinite(pose.heading().radians()))
    return Error{ErrorCode::invalid, "insert_scan: the pose is not finite"};
  return {};
}

[[nodiscard]] inline ScanUpdate update_of(const InverseLidarModel& m) {
  return {LogOdds::from_probability(m.p_free), LogOdds::from_probability(m.p_hit),
          m.fill_gap.radians()};
}

/// Puts the rays of a scan into `raster`; returns their origin.
template <class FreeSpace>
Result<SubCellPoint> lay_rays(ScanRaster& raster, double resolution_m, const SE2d& T_map_laser,
                              const LaserScan& scan, const InverseLidarModel& model) {
  if (auto ok = check(model, T_map_laser); !ok) return ok.error();
  auto& rays = raster.rays();
  rays.resize(scan.ranges_m.size());
  std::size_t used = 0;
  const auto& directions = raster.directions(scan);
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const bool returned = scan.returned(i);
    const double range =
        returned ? static_cast<double>(scan.ranges_m[i]) : model.free_range_without_return_m;
    if (!(range > 0)) continue;
    const double length = std::min(range, model.max_usable_range_m);
    const Eigen::Vector2d end = T_map_laser * Eigen::Vector2d(length * directions[i]);
    const double bearing = FreeSpace::kFills ? scan.bearing(i).radians() : 0.0;
    rays[used++] = {SubCellPoint::of(end, resolution_m), static_cast<float>(bearing),
                    returned && range <= model.max_usable_range_m};
  }
  rays.resize(used);
  return SubCellPoint::of(T_map_laser.translation(), resolution_m);
}

/// The same for rays from `origin` to points.
template <class FreeSpace>
Result<SubCellPoint> lay_rays(ScanRaster& raster, double resolution_m, const SE2d& T_map_points,
                              const PointSet& points, const InverseLidarModel& model,
                              const Eigen::Vector2d& origin) {
  if (auto ok = check(model, T_map_points); !ok) return ok.error();
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
    const double bearing = FreeSpace::kFills ? std::atan2(beam.y(), beam.x()) : 0.0;
    rays.push_back({SubCellPoint::of(end, resolution_m), static_cast<float>(bearing),
                    range <= model.max_usable_range_m});
  }
  return SubCellPoint::of(T_map_points * origin, resolution_m);
}

}  // namespace detail

/// Updates `grid` with one scan taken at `T_map_laser`. The grid is as it was when an Error comes
/// back (a pose that is not finite, a model out of range, a scan too large for the raster or
/// farther from the map's origin than cells are numbered).
template <class FreeSpace = OncePerScan>
Result<void> insert_scan(OccupancyGrid& grid, const SE2d& T_map_laser, const LaserScan& scan,
                         const InverseLidarModel& model, ScanRaster& raster) {
  const auto from =
      detail::lay_rays<FreeSpace>(raster, grid.resolution_m(), T_map_laser, scan, model);
  if (!from) return from.error();
  return raster.apply<FreeSpace>(grid, *from, detail::update_of(model));
}

/// The same for end points in the frame `T_map_points` leads from, with `origin` (the sensor, in
/// that frame) as the start of every ray. Points that are not finite are refused. To fill between
/// beams, the points must be in the order of their bearings.
template <class FreeSpace = OncePerScan>
Result<void> insert_points(OccupancyGrid& grid, const SE2d& T_map_points, const PointSet& points,
                           const InverseLidarModel& model, ScanRaster& raster,
                           const Eigen::Vector2d& origin = Eigen::Vector2d::Zero()) {
  const auto from =
      detail::lay_rays<FreeSpace>(raster, grid.resolution_m(), T_map_points, points, model, origin);
  if (!from) return from.error();
  return raster.apply<FreeSpace>(grid, *from, detail::update_of(model));
}

}  // namespace wayfare
