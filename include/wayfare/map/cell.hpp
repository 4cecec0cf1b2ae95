#pragma once

// Cells of a grid: coordinates, boxes, and the cells on a segment.

#include <algorithm>
#include <cmath>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <optional>

#include <Eigen/Core>

#include <wayfare/core/detail/eigen_alignment.hpp>

namespace wayfare {

/// A square of the grid: cell (i, j) is [i, i+1) × [j, j+1) times the resolution, in map axes. The
/// map's origin is the lower-left corner of cell (0, 0) of every grid.
struct Cell {
  int x = 0;  ///< column, along the map's x
  int y = 0;  ///< row, along the map's y

  /// @{
  /// By component, such as of a cell and an offset.
  constexpr Cell operator+(const Cell& o) const { return {x + o.x, y + o.y}; }
  constexpr Cell operator-(const Cell& o) const { return {x - o.x, y - o.y}; }
  /// @}
  /// By x, then by y.
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
  Cell min;  ///< lower-left corner, included
  Cell max;  ///< upper-right corner, included

  /// Columns.
  [[nodiscard]] std::int64_t width() const { return std::int64_t{max.x} - min.x + 1; }
  /// Rows.
  [[nodiscard]] std::int64_t height() const { return std::int64_t{max.y} - min.y + 1; }
  /// Whether the cell is in the box.
  [[nodiscard]] bool contains(const Cell& c) const {
    return c.x >= min.x && c.x <= max.x && c.y >= min.y && c.y <= max.y;
  }
  /// By `by` cells on every side.
  [[nodiscard]] CellBox grown(int by) const { return {min - Cell{by, by}, max + Cell{by, by}}; }
  /// Number of cells.
  [[nodiscard]] std::int64_t cells() const { return width() * height(); }
  /// Of a cell of the box, row by row from `min`.
  [[nodiscard]] std::size_t index(const Cell& c) const {
    return static_cast<std::size_t>((c.y - min.y) * width() + c.x - min.x);
  }
  /// To the smallest box that also contains `c`.
  void extend(const Cell& c) {
    min = {std::min(min.x, c.x), std::min(min.y, c.y)};
    max = {std::max(max.x, c.x), std::max(max.y, c.y)};
  }
  /// By `min`, then by `max`.
  auto operator<=>(const CellBox&) const = default;
};

/// The cells of both boxes, if there are any.
[[nodiscard]] inline std::optional<CellBox> common_cells(const CellBox& a, const CellBox& b) {
  const CellBox box{{std::max(a.min.x, b.min.x), std::max(a.min.y, b.min.y)},
                    {std::min(a.max.x, b.max.x), std::min(a.max.y, b.max.y)}};
  return box.min.x <= box.max.x && box.min.y <= box.max.y ? std::optional(box) : std::nullopt;
}

/// A point in 1/4096 of a cell, so that the traversal below is exact in integers.
struct SubCellPoint {
  static constexpr int kBits = 12;  ///< of the fraction of a cell
  std::int64_t x = 0;               ///< along the map's x
  std::int64_t y = 0;               ///< along the map's y

  /// Rounded down, so that its cell is cell_of(p). Saturates like cell_of.
  [[nodiscard]] static SubCellPoint of(const Eigen::Vector2d& p_map, double resolution_m) {
    return {coordinate(p_map.x() / resolution_m), coordinate(p_map.y() / resolution_m)};
  }
  /// The cell that contains the point.
  [[nodiscard]] Cell cell() const {
    return {static_cast<int>(x >> kBits), static_cast<int>(y >> kBits)};
  }

 private:
  static std::int64_t coordinate(double cells) {
    constexpr double kLimit = kMaxCell;
    const double inside = cells > -kLimit ? (cells < kLimit ? cells : kLimit) : -kLimit;
    const double scaled = inside * (1 << kBits);
    const auto towards_zero = static_cast<std::int64_t>(scaled);
    return towards_zero - (static_cast<double>(towards_zero) > scaled ? 1 : 0);
  }
};

/// Calls `visit(Cell)` once, in order, for every cell on the segment from `a` to `b`: the cells of
/// both ends, and between them every (half-open) cell that contains a piece of the segment of
/// positive length. Through a corner the traversal is therefore diagonal. Both directions visit the
/// same cells, except if an end touches a cell boundary without crossing it.
/// Amanatides and Woo 1987, with the crossing parameters compared as integers:
/// err = (distance to the next vertical line)·|dy| − (distance to the next horizontal line)·|dx|.
template <class Visit>
void for_each_cell_on_segment(const SubCellPoint& a, const SubCellPoint& b, Visit&& visit) {
  constexpr std::int64_t kOne = std::int64_t{1} << SubCellPoint::kBits;
  const std::int64_t dx = std::abs(b.x - a.x), dy = std::abs(b.y - a.y);
  const int step_x = b.x >= a.x ? 1 : -1, step_y = b.y >= a.y ? 1 : -1;
  const std::int64_t in_x = a.x & (kOne - 1), in_y = a.y & (kOne - 1);
  Cell cell = a.cell();
  const Cell end = b.cell();
  int left_x = std::abs(end.x - cell.x), left_y = std::abs(end.y - cell.y);
  const std::int64_t err_x = kOne * dy, err_y = kOne * dx;
  std::int64_t err =
      (step_x > 0 ? kOne - in_x : in_x) * dy - (step_y > 0 ? kOne - in_y : in_y) * dx;
  visit(cell);
  while (left_x > 0 && left_y > 0) {
    if (err <= 0) {
      cell.x += step_x;
      --left_x;
    }
    if (err >= 0) {
      cell.y += step_y;
      --left_y;
    }
    err += (err <= 0 ? err_x : 0) - (err >= 0 ? err_y : 0);
    visit(cell);
  }
  for (; left_x > 0; --left_x) visit(Cell{cell.x += step_x, cell.y});
  for (; left_y > 0; --left_y) visit(Cell{cell.x, cell.y += step_y});
}

/// The same for points of the map, m.
template <class Visit>
void for_each_cell_on_segment(const Eigen::Vector2d& a_map, const Eigen::Vector2d& b_map,
                              double resolution_m, Visit&& visit) {
  for_each_cell_on_segment(SubCellPoint::of(a_map, resolution_m),
                           SubCellPoint::of(b_map, resolution_m), visit);
}

}  // namespace wayfare
