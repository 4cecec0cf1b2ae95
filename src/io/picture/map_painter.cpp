#include <wayfare/io/map_image.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace wayfare::io {

/// Of the pixels at one place the last drawn, by rows.
void MapPainter::keep_last(std::vector<Pixel>& pixels) {
  const auto place = [](const Pixel& p) { return std::pair(p.row, p.column); };
  std::ranges::stable_sort(pixels, {}, place);
  const auto same = [&](const Pixel& a, const Pixel& b) { return place(a) == place(b); };
  // From the end: the first of those that remain is the last drawn.
  const auto kept = std::unique(pixels.rbegin(), pixels.rend(), same);
  pixels.erase(pixels.begin(), kept.base());
}

void MapPainter::add(double row, double column, const Colour& colour) {
  constexpr std::size_t kFew = 1 << 16;
  if (drawn_.size() >= 2 * sorted_ + kFew) {
    keep_last(drawn_);
    sorted_ = drawn_.size();
  }
  drawn_.push_back({static_cast<std::uint32_t>(row), static_cast<std::uint32_t>(column), colour});
}

PictureRows MapPainter::rows() const {
  std::vector<Pixel> kept = drawn_;
  keep_last(kept);
  return {grid_.width(), grid_.height(),
          [base = picture_rows(grid_), drawn = std::move(kept)](std::size_t row,
                                                                std::span<std::uint8_t> pixels) {
            base.draw(row, pixels);
            auto p = std::partition_point(drawn.begin(), drawn.end(),
                                          [&](const Pixel& other) { return other.row < row; });
            for (; p != drawn.end() && p->row == row; ++p)
              std::copy(p->colour.begin(), p->colour.end(),
                        pixels.begin() + 3 * static_cast<std::ptrdiff_t>(p->column));
          }};
}

MapPainter& MapPainter::dot(const Eigen::Vector2d& position_m, const Colour& colour, int side) {
  const Eigen::Vector2d cell = (grid_.origin().inverse() * position_m) / grid_.resolution_m();
  if (!cell.allFinite() || side <= 0) return *this;
  const auto width = static_cast<double>(grid_.width());
  const auto height = static_cast<double>(grid_.height());
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
      add(row, column, colour);
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
  const SE2d T_grid_map = grid_.origin().inverse();
  const double resolution_m = grid_.resolution_m();
  constexpr double kMost = 1e15;  // beyond, the pieces' positions are not exact to a pixel
  const Eigen::Vector2d size(static_cast<double>(grid_.width()),
                             static_cast<double>(grid_.height()));
  for (std::size_t i = 1; i < positions_m.size(); ++i) {
    const Eigen::Vector2d step = positions_m[i] - positions_m[i - 1];
    const Eigen::Vector2d begin = (T_grid_map * positions_m[i - 1]) / resolution_m;
    const double pieces = 1.0 + std::floor(step.norm() / (0.5 * resolution_m));
    if (!(pieces < kMost) || !begin.allFinite()) continue;
    const auto [first, last] = visible(begin, T_grid_map.rotation() * step / resolution_m, size);
    const double end = std::min(pieces, std::ceil(last * pieces) + 1.0);
    for (double k = std::max(0.0, std::floor(first * pieces)); k < end; k += 1.0)
      dot(positions_m[i - 1] + step * k / pieces, colour);
  }
  return *this;
}

}  // namespace wayfare::io
