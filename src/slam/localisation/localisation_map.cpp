#include <wayfare/system/localisation.hpp>

namespace wayfare {

Result<std::shared_ptr<const LocalisationMap>> LocalisationMap::make(
    const OccupancyGrid& grid, const LocalisationMapOptions& options) {
  const auto distances = DistanceField::of_grid(grid, options.occupied_probability);
  if (!distances) return distances.error();
  const double floor = options.floor_probability;
  auto sharp = likelihood_field(*distances, {options.sigma_m, floor});
  if (!sharp) return sharp.error();
  auto broad = likelihood_field(*distances, {options.search_sigma_m, floor});
  if (!broad) return broad.error();

  auto map = std::make_shared<LocalisationMap>();
  map->options_ = options;
  map->sharp_ = *std::move(sharp);
  map->broad_ = *std::move(broad);
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
        map->places_.push_back(c);
    }
  if (!wall) return Error{ErrorCode::invalid, "LocalisationMap: the map has no wall"};
  if (map->places_.empty())
    return Error{ErrorCode::invalid, "LocalisationMap: the map has no free place"};
  return std::shared_ptr<const LocalisationMap>(std::move(map));
}

}  // namespace wayfare
