#include <wayfare/io/map_image.hpp>

#include <cmath>
#include <cstddef>

namespace wayfare::io {

GridImage grid_image(const OccupancyGrid& map) {
  const CellBox box = map.bounds().value_or(CellBox{});
  GridImage image;
  image.width = static_cast<std::size_t>(box.width());
  image.height = static_cast<std::size_t>(box.height());
  image.resolution_m = map.resolution_m();
  // Rounded to the nanometre, since the product may be -1.4000000000000001 instead of -1.4.
  const auto metres = [&](int cells) { return std::round(cells * map.resolution_m() * 1e9) / 1e9; };
  image.origin = SE2d(metres(box.min.x), metres(box.min.y), Angle{});
  image.occupancy.reserve(image.width * image.height);
  for (int y = box.min.y; y <= box.max.y; ++y) {
    for (int x = box.min.x; x <= box.max.x; ++x) {
      const Cell cell{x, y};
      image.occupancy.push_back(map.observed(cell) ? static_cast<float>(map.probability(cell))
                                                   : std::nanf(""));
    }
  }
  return image;
}

}  // namespace wayfare::io
