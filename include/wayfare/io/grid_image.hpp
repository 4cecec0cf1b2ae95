#pragma once

#include <wayfare/io/map_image.hpp>
#include <wayfare/map/occupancy_grid.hpp>

namespace wayfare::io {

/// The cells of `map` within its bounds; a single unknown one where nothing was observed.
[[nodiscard]] GridImage grid_image(const OccupancyGrid& map);

}  // namespace wayfare::io
