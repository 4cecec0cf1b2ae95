#pragma once

#include <algorithm>
#include <cmath>
#include <compare>
#include <cstddef>
#include <cstdint>

#include <Eigen/Core>

namespace wayfare {

/// A square of the grid: cell (i, j) is [i, i+1) × [j, j+1) times the resolution, in map axes. The
/// map's origin is the lower-left corner of cell (0, 0) of every grid.
struct Cell {
  int x = 0;
  int y = 0;

  constexpr Cell operator+(const Cell& o) const { return {x + o.x, y + o.y}; }
  constexpr Cell operator-(const Cell& o) const { return {x - o.x, y - o.y}; }
  constexpr auto operator<=>(const Cell&) const = default;
};

/// Cell coordinates stay within ±kMaxCell, so that sums and differences of two fit an int.
inline constexpr int kMaxCell = 1 << 29;

/// floor(metres / resolution), saturated at ±kMaxCell; NaN gives −kMaxCell.
[[nodiscard]] inline int cell_coordinate(double metres, double resolution_m) {
  const double cell = std::floor(metres / resolution_m);
  if (!(cell > -kMaxCell)) return -kMaxCell;
  return static_cast<int>(std::min(cell, static_cast<double>(kMaxCell)));
}

/// The cell that contains a point of the map.
[[nodiscard]] inline Cell cell_of(const Eigen::Vector2d& p_map, double resolution_m) {
  return {cell_coordinate(p_map.x(), resolution_m), cell_coordinate(p_map.y(), resolution_m)};
}

/// Centre of a cell, metres.
[[nodiscard]] inline Eigen::Vector2d centre_of(const Cell& cell, double resolution_m) {
  return {(cell.x + 0.5) * resolution_m, (cell.y + 0.5) * resolution_m};
}

/// A rectangle of cells, both corners included.
struct CellBox {
  Cell min;
  Cell max;

  [[nodiscard]] std::int64_t width() const { return std::int64_t{max.x} - min.x + 1; }
  [[nodiscard]] std::int64_t height() const { return std::int64_t{max.y} - min.y + 1; }
  [[nodiscard]] bool contains(const Cell& c) const {
    return c.x >= min.x && c.x <= max.x && c.y >= min.y && c.y <= max.y;
  }
  [[nodiscard]] CellBox grown(int by) const { return {min - Cell{by, by}, max + Cell{by, by}}; }
  [[nodiscard]] std::int64_t cells() const { return width() * height(); }
  /// Of a cell of the box, row by row from `min`.
  [[nodiscard]] std::size_t index(const Cell& c) const {
    return static_cast<std::size_t>((c.y - min.y) * width() + c.x - min.x);
  }
  void extend(const Cell& c) {
    min = {std::min(min.x, c.x), std::min(min.y, c.y)};
    max = {std::max(max.x, c.x), std::max(max.y, c.y)};
  }
  auto operator<=>(const CellBox&) const = default;
};

}  // namespace wayfare
