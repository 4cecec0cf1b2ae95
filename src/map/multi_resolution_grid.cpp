#include <wayfare/map/multi_resolution_grid.hpp>

#include <algorithm>

namespace wayfare {
namespace {

/// The cells a scan from this pose can change.
CellBox box_of(const SE2d& T_map_laser, const LaserScan& scan, const InverseLidarModel& model,
               double resolution_m) {
  const Cell from = cell_of(T_map_laser.translation(), resolution_m);
  CellBox box{from, from};
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const double range = scan.returned(i) ? static_cast<double>(scan.ranges_m[i])
                                          : model.free_range_without_return_m;
    const double length = std::min(range, model.max_usable_range_m);
    const double bearing = scan.bearing(i).radians();
    const Eigen::Vector2d end(length * std::cos(bearing), length * std::sin(bearing));
    box.extend(cell_of(T_map_laser * end, resolution_m));
  }
  return box;
}

}  // namespace

MultiResolutionGrid::MultiResolutionGrid(const MultiResolutionOptions& options)
    : options_(options) {
  WAYFARE_EXPECTS(options.levels >= 1 && options.levels <= 8, "one to eight levels");
  for (int level = options.levels - 1; level >= 0; --level) {
    OccupancyGridOptions shape = options.finest;
    shape.resolution_m *= 1 << level;
    grids_.emplace_back(shape);
  }
}

template <class InsertInto, class BoxAt>
Result<void> MultiResolutionGrid::insert_into_all(const InsertInto& insert_into,
                                                  const BoxAt& box_at) {
  for (OccupancyGrid& grid : grids_)
    if (auto ok = insert_into(grid); !ok) return ok;
  tables_.resize(grids_.size());
  for (std::size_t i = 0; i < grids_.size(); ++i)
    if (auto ok = update_table(i, box_at(grids_[i].resolution_m())); !ok) return ok;
  return {};
}

Result<void> MultiResolutionGrid::insert(const SE2d& T_map_laser, const LaserScan& scan) {
  return insert_into_all(
      [&](OccupancyGrid& grid) {
        return insert_scan(grid, T_map_laser, scan, options_.model, raster_);
      },
      [&](double resolution_m) { return box_of(T_map_laser, scan, options_.model, resolution_m); });
}

Result<void> MultiResolutionGrid::insert(const SE2d& T_map_points, const PointSet& points,
                                         const Eigen::Vector2d& origin) {
  return insert_into_all(
      [&](OccupancyGrid& grid) {
        return insert_points(grid, T_map_points, points, options_.model, raster_, origin);
      },
      [&](double resolution_m) {
        const Cell from = cell_of(T_map_points * origin, resolution_m);
        CellBox box{from, from};
        for (std::size_t i = 0; i < points.size(); ++i)
          box.extend(
              cell_of(T_map_points * Eigen::Vector2d(points[i].cast<double>()), resolution_m));
        // Rounding may move an end point into a neighbouring cell.
        return CellBox{box.min - Cell{1, 1}, box.max + Cell{1, 1}};
      });
}

std::size_t MultiResolutionGrid::memory_bytes() const {
  std::size_t sum = 0;
  for (const OccupancyGrid& grid : grids_)
    grid.for_each_tile(
        [&](const Cell&, std::span<const std::int16_t> cells) { sum += cells.size_bytes(); });
  for (const ProbabilityGrid& table : tables_)
    sum += sizeof(std::uint16_t) * static_cast<std::size_t>(table.stride()) *
           static_cast<std::size_t>(table.height() + 2 * PaddedTable::kBorder);
  return sum;
}

/// A table that is too small is rebuilt with a spare margin, so that rebuilding is rare.
Result<void> MultiResolutionGrid::update_table(std::size_t level, const CellBox& changed) {
  constexpr double kSpare_m = 5.0;
  const OccupancyGrid& grid = grids_[level];
  if (!grid.bounds() || tables_[level].update(grid, changed)) return {};
  return tables_[level].make(grid, options_.unknown_probability,
                             static_cast<int>(kSpare_m / grid.resolution_m()));
}

}  // namespace wayfare
