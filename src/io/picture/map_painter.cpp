#include <wayfare/io/map_image.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

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
  if (!cell.allFinite()) return *this;
  const auto width = static_cast<double>(picture_.width);
  const auto height = static_cast<double>(picture_.height);
  const double before = 0.5 * (static_cast<double>(side) - 1.0);
  // Of the rows or columns of the square, those that may be within the picture.
  const auto first = [&](double at) {
    return static_cast<int>(std::clamp(std::floor(before - at), 0.0, static_cast<double>(side)));
  };
  const auto last = [&](double at, double size) {
    return static_cast<int>(
        std::clamp(std::ceil(size + before - at) + 1.0, 0.0, static_cast<double>(side)));
  };
  if (side <= 0) return *this;
  for (int i = first(cell.x()); i < last(cell.x(), width); ++i) {
    for (int j = first(cell.y()); j < last(cell.y(), height); ++j) {
      const double column = std::floor(cell.x() + i - before);
      const double row = height - 1.0 - std::floor(cell.y() + j - before);
      if (!(column >= 0.0 && row >= 0.0 && column < width && row < height)) continue;
      const std::size_t at =
          3 * (static_cast<std::size_t>(row) * picture_.width + static_cast<std::size_t>(column));
      std::copy(colour.begin(), colour.end(), picture_.pixels.begin() + static_cast<long>(at));
    }
  }
  return *this;
}

/// The part of a segment, as fractions of it, that may be visible in the picture.
std::pair<double, double> MapPainter::visible(const Eigen::Vector2d& from,
                                              const Eigen::Vector2d& step) const {
  const Eigen::Vector2d begin = (T_grid_map_ * from) / resolution_m_;
  const Eigen::Vector2d along = T_grid_map_.rotation() * step / resolution_m_;
  const Eigen::Vector2d size(static_cast<double>(picture_.width),
                             static_cast<double>(picture_.height));
  constexpr double kMargin = 4.0;  // pixels
  double first = 0.0, last = 1.0;
  for (int axis = 0; axis < 2; ++axis) {
    double enters = (-kMargin - begin[axis]) / along[axis];
    double leaves = (size[axis] + kMargin - begin[axis]) / along[axis];
    if (enters > leaves) std::swap(enters, leaves);
    if (along[axis] == 0.0) continue;
    first = std::max(first, enters);
    last = std::min(last, leaves);
  }
  return {first, last};
}

MapPainter& MapPainter::path(std::span<const Eigen::Vector2d> positions_m, const Colour& colour) {
  constexpr double kMost = 1e15;  // pieces of a segment; beyond, positions are not exact to a pixel
  for (std::size_t i = 1; i < positions_m.size(); ++i) {
    const Eigen::Vector2d step = positions_m[i] - positions_m[i - 1];
    const double pieces = 1.0 + std::floor(step.norm() / (0.5 * resolution_m_));
    if (!(pieces < kMost)) continue;
    const auto [first, last] = visible(positions_m[i - 1], step);
    const double end = std::min(pieces, std::ceil(last * pieces) + 1.0);
    for (double k = std::max(0.0, std::floor(first * pieces)); k < end; k += 1.0)
      dot(positions_m[i - 1] + step * k / pieces, colour);
  }
  return *this;
}

}  // namespace wayfare::io
