#pragma once

// Every map of a small room, with what can be observed of it as a list of numbers.

#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/map/detail/precomputation_grids.hpp>
#include <wayfare/map/distance_field.hpp>
#include <wayfare/map/inverse_lidar.hpp>
#include <wayfare/map/likelihood_field.hpp>
#include <wayfare/map/ndt_map.hpp>
#include <wayfare/map/occupancy_grid.hpp>
#include <wayfare/map/probability_grid.hpp>
#include <wayfare/map/surface_map.hpp>

#include "match/walls.hpp"

namespace wayfare::tests {

using Observed = std::vector<double>;

inline constexpr float kNanF = std::numeric_limits<float>::quiet_NaN();
inline constexpr float kInfF = std::numeric_limits<float>::infinity();

/// A Result's Error says something.
template <class R>
void expect_refused(const R& result, const std::string& what) {
  ASSERT_FALSE(result) << what;
  EXPECT_GT(result.error().to_string().size(), 15U) << what;
}

inline SE2d pose_in_room(int k) {
  return {0.4 * (k % 5) - 0.8, 0.3 * (k % 3) - 0.4, Angle::degrees(35.0 * k)};
}
inline LaserScan scan_in_room(int k) {
  Rng rng(static_cast<std::uint64_t>(k) + 1);
  LaserScan scan = Walls::room().scan(pose_in_room(k), rng);
  scan.bearing_step = scan.bearing_step * 4.0;
  scan.ranges_m.resize(90);
  return scan;
}
/// In the laser's axes.
inline PointSet points_in_room(int k) { return end_points(scan_in_room(k)); }

inline PointSet points_at(const std::vector<Eigen::Vector2f>& list) {
  PointSet points;
  for (const Eigen::Vector2f& p : list) points.push_back(p);
  return points;
}

/// Not finite, or farther than any cell.
inline std::vector<SE2d> bad_poses() {
  return {{kNan, 0, Angle()},
          {0, kInf, Angle()},
          {0, 0, Angle::radians(kNan)},
          {0, 0, Angle::radians(kInf)},
          {1e300, -1e300, Angle()}};
}

inline OccupancyGrid room_grid(double resolution_m = 0.1, int scans = 3) {
  OccupancyGrid grid({.resolution_m = resolution_m});
  ScanRaster raster;
  for (int k = 0; k < scans; ++k)
    (void)insert_scan(grid, pose_in_room(k), scan_in_room(k), {}, raster);
  return grid;
}

/// Calls `f(placed scans)` with `scans` views of the room.
template <class F>
auto with_views(const F& f, int scans = 3) {
  std::vector<PointSet> points;
  std::vector<PlacedPoints> placed;
  for (int k = 0; k < scans; ++k) points.push_back(points_in_room(k));
  for (int k = 0; k < scans; ++k)
    placed.push_back({&points[static_cast<std::size_t>(k)], pose_in_room(k)});
  return f(std::span<const PlacedPoints>(placed));
}

inline void observe(const OccupancyGrid& grid, Observed& out) {
  out.push_back(grid.resolution_m());
  out.push_back(static_cast<double>(grid.tiles().tile_count()));
  if (const auto& box = grid.bounds())
    out.insert(out.end(), {1.0 * box->min.x, 1.0 * box->min.y, 1.0 * box->max.x, 1.0 * box->max.y});
  grid.for_each_tile([&](const Cell& corner, std::span<const std::int16_t> cells) {
    out.insert(out.end(), {1.0 * corner.x, 1.0 * corner.y});
    out.insert(out.end(), cells.begin(), cells.end());
  });
}
inline void observe(const PaddedTable& table, Observed& out) {
  out.insert(out.end(), {1.0 * table.width(), 1.0 * table.height()});
  if (table.empty()) return;
  out.insert(out.end(), {table.resolution_m(), 1.0 * table.origin().x, 1.0 * table.origin().y});
  for (int y = -PaddedTable::kBorder; y < table.height() + PaddedTable::kBorder; ++y) {
    const std::uint16_t* row = table.data() + std::ptrdiff_t{y} * table.stride();
    out.insert(out.end(), row - PaddedTable::kBorder, row + table.width() + PaddedTable::kBorder);
  }
}
inline void observe(const LikelihoodField& field, Observed& out) {
  observe(static_cast<const PaddedTable&>(field), out);
  if (!field.empty()) out.insert(out.end(), {field.log_floor(), field.log_step()});
}
inline void observe(const ProbabilityGrid& grid, Observed& out) {
  observe(static_cast<const PaddedTable&>(grid), out);
  if (!grid.empty()) out.push_back(grid.unknown());
}
inline void observe(const PrecomputationGrids& grids, Observed& out) {
  observe(grids.grid(), out);
  for (int l = 0; !grids.grid().empty() && l < PrecomputationGrids::kLevels; ++l)
    out.insert(out.end(), grids.level(l).table.begin(), grids.level(l).table.end());
}
inline void observe(const DistanceField& field, Observed& out) {
  out.insert(out.end(), {1.0 * field.width(), 1.0 * field.height()});
  for (int y = 0; y < field.height(); ++y)
    out.insert(out.end(), field.row(y).begin(), field.row(y).end());
}
inline void observe(const RayCaster& caster, Observed& out) {
  std::vector<float> cosines, sines, ranges(100);
  for (int i = 0; i < 100; ++i) {
    cosines.push_back(static_cast<float>(std::cos(0.063 * i)));
    sines.push_back(static_cast<float>(std::sin(0.063 * i)));
  }
  caster.cast(pose_in_room(1), cosines, sines, 20.0, ranges);
  out.insert(out.end(), ranges.begin(), ranges.end());
}
inline void observe(const SurfaceMap& map, Observed& out) {
  for (const SurfacePoint& s : map.points()) {
    out.insert(out.end(), s.point.begin(), s.point.end());
    out.insert(out.end(), s.normal.begin(), s.normal.end());
    const SurfacePoint* found = map.nearest(s.point + Eigen::Vector2f(0.3F, 0.1F), 0.5F);
    out.push_back(found == nullptr ? -1.0 : static_cast<double>(found - map.points().data()));
  }
}
inline void observe(const NdtMap& map, Observed& out) {
  for (const NdtMap::Level& level : map.levels())
    for (double x = -6; x < 6; x += 0.37)
      for (double y = -4; y < 4; y += 0.37)
        for (int t = 0; t < NdtMap::Level::kTilings; ++t) {
          const NdtCell* cell = level.at({x, y}, t);
          out.push_back(cell == nullptr ? 0.0 : cell->mean.sum());
          if (cell != nullptr) out.push_back(cell->information.sum());
        }
}
inline void observe(const MultiResolutionGrid& map, Observed& out) {
  out.insert(out.end(), {map.empty() ? 1.0 : 0.0, static_cast<double>(map.memory_bytes())});
  observe(map.finest(), out);
  for (const ProbabilityGrid& table : map.tables()) observe(table, out);
}

template <class T>
[[nodiscard]] Observed observed(const T& object) {
  Observed out;
  observe(object, out);
  return out;
}

/// `make<Map>(scans)`: a map of the room from this number of scans.
template <class Map>
Map make(int scans);

template <>
inline OccupancyGrid make(int scans) {
  return room_grid(0.1, scans);
}
template <>
inline LikelihoodField make(int scans) {
  return with_views([](auto views) { return *likelihood_field(views); }, scans);
}
template <>
inline PrecomputationGrids make(int scans) {
  return PrecomputationGrids(make<LikelihoodField>(scans));
}
template <>
inline ProbabilityGrid make(int scans) {
  ProbabilityGrid grid;
  (void)grid.make(room_grid(0.1, scans), 0.5, 3);
  return grid;
}
template <>
inline ProbabilityPyramid make(int scans) {
  ProbabilityPyramid tables;
  for (const double cell : {0.2, 0.1}) {
    (void)tables.emplace_back().make(room_grid(cell, scans), 0.1);
  }
  return tables;
}
template <>
inline DistanceField make(int scans) {
  return *DistanceField::of_grid(room_grid(0.1, scans));
}
template <>
inline RayCaster make(int scans) {
  return RayCaster(make<DistanceField>(scans));
}
template <>
inline SurfaceMap make(int scans) {
  // A beam every four degrees: neighbours are up to half a metre apart.
  return with_views([](auto views) { return *SurfaceMap::make(views, {.normal_radius_m = 0.5}); },
                    scans);
}
template <>
inline NdtMap make(int scans) {
  return with_views([](auto views) { return *NdtMap::make(views); }, scans);
}
template <>
inline MultiResolutionGrid make(int scans) {
  MultiResolutionOptions options;
  options.finest.resolution_m = 0.1;
  MultiResolutionGrid map(options);
  for (int k = 0; k < scans; ++k) (void)map.insert(pose_in_room(k), scan_in_room(k));
  return map;
}

}  // namespace wayfare::tests
