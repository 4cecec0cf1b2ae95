#include <wayfare/io/map_image.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace wayfare::io {

MapPainter::MapPainter(const GridImage& grid)
    : T_grid_map_(grid.origin.inverse()), resolution_m_(grid.resolution_m) {
  const Image grey = to_picture(grid);
  picture_ = {grey.width, grey.height, 3, {}};
  picture_.pixels.reserve(3 * grey.width * grey.height);
  for (std::size_t i = 0; i < grey.width * grey.height; ++i)
    for (std::size_t c = 0; c < 3; ++c)
      picture_.pixels.push_back(grey.pixels[i * grey.channels + (grey.channels == 3 ? c : 0)]);
}

MapPainter& MapPainter::dot(const Eigen::Vector2d& position_m, const Colour& colour, int side) {
  const Eigen::Vector2d cell = (T_grid_map_ * position_m) / resolution_m_;
  const auto width = static_cast<double>(picture_.width);
  const auto height = static_cast<double>(picture_.height);
  for (int i = 0; i < side; ++i) {
    for (int j = 0; j < side; ++j) {
      const double column = std::floor(cell.x() + i - 0.5 * (side - 1));
      const double row = height - 1.0 - std::floor(cell.y() + j - 0.5 * (side - 1));
      if (!(column >= 0.0 && row >= 0.0 && column < width && row < height)) continue;
      const std::size_t at =
          3 * (static_cast<std::size_t>(row) * picture_.width + static_cast<std::size_t>(column));
      std::copy(colour.begin(), colour.end(), picture_.pixels.begin() + static_cast<long>(at));
    }
  }
  return *this;
}

MapPainter& MapPainter::path(std::span<const Eigen::Vector2d> positions_m, const Colour& colour) {
  for (std::size_t i = 1; i < positions_m.size(); ++i) {
    const Eigen::Vector2d step = positions_m[i] - positions_m[i - 1];
    const int pieces = 1 + static_cast<int>(step.norm() / (0.5 * resolution_m_));
    for (int k = 0; k < pieces; ++k) dot(positions_m[i - 1] + step * k / pieces, colour);
  }
  return *this;
}

}  // namespace wayfare::io
