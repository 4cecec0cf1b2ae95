#include <wayfare/io/map_image.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace wayfare::io {

MapPainter::MapPainter(const GridImage& grid)
    : T_grid_map_(grid.origin.inverse()),
      resolution_m_(grid.resolution_m),
      picture_(to_picture(grid)) {}

MapPainter& MapPainter::dot(const Eigen::Vector2d& position_m, const Colour& colour, int side) {
  const Eigen::Vector2d cell = (T_grid_map_ * position_m) / resolution_m_;
  if (!cell.allFinite() || side <= 0) return *this;
  const auto width = static_cast<double>(picture_.width);
  const auto height = static_cast<double>(picture_.height);
  const double before = 0.5 * (side - 1);
  // Of the square's columns or rows, those that may be within the picture.
  const auto range = [&](double at, double size) {
    const auto within = [count = static_cast<double>(side)](double i) {
      return static_cast<int>(std::clamp(i, 0.0, count));
    };
    return std::pair(within(std::floor(before - at)), within(std::ceil(size + before - at) + 1.0));
  };
  const auto [left, right] = range(cell.x(), width);
  const auto [low, high] = range(cell.y(), height);
  for (int i = left; i < right; ++i) {
    for (int j = low; j < high; ++j) {
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

namespace {

/// The part of the line from `begin` to `begin` + `step`, in pixels, that may be seen in a picture
/// of `size`: its first and last point as fractions of the line.
std::pair<double, double> visible(const Eigen::Vector2d& begin, const Eigen::Vector2d& step,
                                  const Eigen::Vector2d& size) {
  constexpr double kMargin = 4.0;
  double first = 0.0, last = 1.0;
  for (int axis = 0; axis < 2; ++axis) {
    if (step[axis] == 0.0) continue;
    const double low = (-kMargin - begin[axis]) / step[axis];
    const double high = (size[axis] + kMargin - begin[axis]) / step[axis];
    first = std::max(first, std::min(low, high));
    last = std::min(last, std::max(low, high));
  }
  return {first, last};
}

}  // namespace

MapPainter& MapPainter::path(std::span<const Eigen::Vector2d> positions_m, const Colour& colour) {
  constexpr double kMost = 1e15;  // beyond, the pieces' positions are not exact to a pixel
  const Eigen::Vector2d size(static_cast<double>(picture_.width),
                             static_cast<double>(picture_.height));
  for (std::size_t i = 1; i < positions_m.size(); ++i) {
    const Eigen::Vector2d step = positions_m[i] - positions_m[i - 1];
    const Eigen::Vector2d begin = (T_grid_map_ * positions_m[i - 1]) / resolution_m_;
    const double pieces = 1.0 + std::floor(step.norm() / (0.5 * resolution_m_));
    if (!(pieces < kMost) || !begin.allFinite()) continue;
    const auto [first, last] = visible(begin, T_grid_map_.rotation() * step / resolution_m_, size);
    const double end = std::min(pieces, std::ceil(last * pieces) + 1.0);
    for (double k = std::max(0.0, std::floor(first * pieces)); k < end; k += 1.0)
      dot(positions_m[i - 1] + step * k / pieces, colour);
  }
  return *this;
}

}  // namespace wayfare::io
