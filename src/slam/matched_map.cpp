#include <wayfare/slam/detail/matched_map.hpp>

#include <algorithm>
#include <cmath>

#include <wayfare/map/inverse_lidar.hpp>

namespace wayfare::detail {

OccupancyGrid grid_of(std::span<const PlacedPoints> scans, const MultiResolutionOptions& options,
                      const Eigen::Vector2d& origin) {
  OccupancyGrid grid(options.finest);
  ScanRaster raster;
  for (const PlacedPoints& scan : scans)
    (void)insert_points(grid, scan.T_map_points, *scan.points, options.model, raster, origin);
  return grid;
}

ProbabilityPyramid table_in_reach(const OccupancyGrid& grid, double unknown_probability,
                                  const PointSet& points, const SE2d& prior,
                                  const SearchWindow& window) {
  constexpr double kMargin_m = 1.0;
  const auto observed = grid.bounds();
  if (!observed) return {};
  std::optional<CellBox> box;
  double range_m = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector2d p = points[i].cast<double>();
    const Cell cell = cell_of(prior * p, grid.resolution_m());
    if (!box) box = CellBox{cell, cell};
    box->extend(cell);
    range_m = std::max(range_m, p.norm());
  }
  if (box) {
    const double reach_m = std::max(window.half_x_m, window.half_y_m) +
                           window.half_heading.radians() * range_m + kMargin_m;
    box = common_cells(box->grown(cell_coordinate(reach_m, grid.resolution_m())), *observed);
  }
  ProbabilityPyramid tables(1);
  if (!tables[0].make(grid, unknown_probability, box.value_or(*observed))) tables.clear();
  return tables;
}

std::size_t memory_bytes(const OccupancyGrid& grid) {
  std::size_t sum = 0;
  grid.for_each_tile(
      [&](const Cell&, std::span<const std::int16_t> cells) { sum += cells.size_bytes(); });
  return sum;
}

}  // namespace wayfare::detail
