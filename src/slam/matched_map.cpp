#include <wayfare/slam/detail/matched_map.hpp>

#include <wayfare/map/inverse_lidar.hpp>

namespace wayfare::detail {

ProbabilityPyramid single_table(std::span<const PlacedPoints> scans,
                                const MultiResolutionOptions& options,
                                const Eigen::Vector2d& origin) {
  OccupancyGrid grid(options.finest);
  ScanRaster raster;
  for (const PlacedPoints& scan : scans)
    (void)insert_points(grid, scan.T_map_points, *scan.points, options.model, raster, origin);
  ProbabilityPyramid tables(1);
  if (!tables[0].make(grid, options.unknown_probability)) tables.clear();
  return tables;
}

std::size_t memory_bytes(const ProbabilityPyramid& tables) {
  std::size_t sum = 0;
  for (const ProbabilityGrid& table : tables)
    sum += sizeof(std::uint16_t) * static_cast<std::size_t>(table.stride()) *
           static_cast<std::size_t>(table.height() + 2 * PaddedTable::kBorder);
  return sum;
}

}  // namespace wayfare::detail
