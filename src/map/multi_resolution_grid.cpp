#include <wayfare/map/probability_grid.hpp>

namespace wayfare {

MultiResolutionGrid::MultiResolutionGrid(const MultiResolutionOptions& options)
    : options_(options) {
  WAYFARE_EXPECTS(options.levels >= 1 && options.levels <= 8, "one to eight levels");
  for (int level = options.levels - 1; level >= 0; --level) {
    OccupancyGridOptions shape = options.finest;
    shape.resolution_m *= 1 << level;
    grids_.emplace_back(shape);
  }
}

/// `lay_rays(resolution_m)` puts the rays of the scan into the raster and returns their origin. All
/// levels are checked before a cell of any of them changes.
template <class LayRays>
Result<void> MultiResolutionGrid::insert_everywhere(const LayRays& lay_rays) {
  std::vector<CellBox> changed;
  for (std::size_t i = 0; i < grids_.size(); ++i) {
    const auto from = lay_rays(grids_[i].resolution_m());
    if (!from) return from.error();
    if (raster_.rays().empty()) continue;
    const auto box = raster_.cover(*from);
    if (!box) return box.error();
    if (auto ok = check_room(i, *box); !ok) return ok;
    changed.push_back(*box);
  }
  tables_.resize(grids_.size());
  for (std::size_t i = 0; i < changed.size(); ++i) {
    const auto from = lay_rays(grids_[i].resolution_m());
    const ScanUpdate update = detail::update_of(options_.model);
    if (auto ok = raster_.apply<OncePerScan>(grids_[i], *from, update); !ok) return ok;
    if (auto ok = follow(i, changed[i]); !ok) return ok;
  }
  return {};
}

Result<void> MultiResolutionGrid::insert(const SE2d& T_map_laser, const LaserScan& scan) {
  return insert_everywhere([&](double resolution_m) {
    return detail::lay_rays(raster_, resolution_m, T_map_laser, scan, options_.model);
  });
}

Result<void> MultiResolutionGrid::insert(const SE2d& T_map_points, const PointSet& points,
                                         const Eigen::Vector2d& origin) {
  return insert_everywhere([&](double resolution_m) {
    return detail::lay_rays<OncePerScan>(raster_, resolution_m, T_map_points, points,
                                         options_.model, origin);
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
int MultiResolutionGrid::margin(const OccupancyGrid& grid) {
  constexpr double kSpare_m = 5.0;
  return cell_coordinate(kSpare_m, grid.resolution_m());
}

/// Whether the table of the level can grow to contain `changed`.
Result<void> MultiResolutionGrid::check_room(std::size_t level, const CellBox& changed) const {
  if (level < tables_.size() && tables_[level].covers(changed)) return {};
  const OccupancyGrid& grid = grids_[level];
  CellBox box = grid.bounds().value_or(changed);
  box.extend(changed.min);
  box.extend(changed.max);
  const auto table = ProbabilityGrid::extent(box, options_.unknown_probability, margin(grid));
  return table ? Result<void>() : table.error();
}

Result<void> MultiResolutionGrid::follow(std::size_t level, const CellBox& changed) {
  const OccupancyGrid& grid = grids_[level];
  if (!grid.bounds() || tables_[level].update(grid, changed)) return {};
  return tables_[level].make(grid, options_.unknown_probability, margin(grid));
}

}  // namespace wayfare
