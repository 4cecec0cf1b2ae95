#include <wayfare/slam/localisation.hpp>

#include <numbers>

namespace wayfare {
namespace {

Result<LocalisationMap::Fields> fields_of(const DistanceField& distances, const FieldShape& shape) {
  auto sharp = likelihood_field(distances, {shape.sigma_m, shape.floor_probability});
  if (!sharp) return sharp.error();
  auto broad = likelihood_field(distances, {shape.search_sigma_m, shape.floor_probability});
  if (!broad) return broad.error();
  return LocalisationMap::Fields{*std::move(sharp), *std::move(broad)};
}

}  // namespace

SE2d LocalisationMap::random_pose(Rng& rng) const {
  const Cell& c = free_cells_[rng.below(free_cells_.size())];
  const double x_m = (c.x + rng.uniform()) * resolution_m();
  const double y_m = (c.y + rng.uniform()) * resolution_m();
  return {x_m, y_m, Angle::radians(rng.uniform(-std::numbers::pi, std::numbers::pi))};
}

Result<std::shared_ptr<const LocalisationMap>> LocalisationMap::make(
    const OccupancyGrid& grid, const LocalisationMapOptions& options, const OccupancyGrid* radar) {
  const auto distances = DistanceField::of_grid(grid, options.occupied_probability);
  if (!distances) return distances.error();
  auto walls = fields_of(*distances, options.lidar);
  if (!walls) return walls.error();

  auto map = std::make_shared<LocalisationMap>();
  map->options_ = options;
  map->fields_[0] = *std::move(walls);
  if (radar) {
    const auto seen = DistanceField::of_grid(*radar, options.seen_probability);
    if (!seen) return seen.error();
    auto fields = fields_of(*seen, options.radar);
    if (!fields) return fields.error();
    map->fields_[1] = *std::move(fields);
  }
  map->rays_ = RayCaster(*distances);
  const CellBox box = *grid.bounds();
  bool wall = false;
  for (int y = box.min.y; y <= box.max.y; ++y)
    for (int x = box.min.x; x <= box.max.x; ++x) {
      const Cell c{x, y};
      const double distance = distances->distance_m(c);
      wall = wall || distance == 0.0;
      if (grid.observed(c) && grid.probability(c) <= options.free_probability &&
          distance >= options.clearance_m)
        map->free_cells_.push_back(c);
    }
  if (!wall) return Error{ErrorCode::invalid, "LocalisationMap: the map has no wall"};
  if (map->free_cells_.empty())
    return Error{ErrorCode::invalid, "LocalisationMap: the map has no free cell"};
  return std::shared_ptr<const LocalisationMap>(std::move(map));
}

}  // namespace wayfare
