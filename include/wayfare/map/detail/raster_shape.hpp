#pragma once

// A window of the plane, cell by cell in memory.

#include <cstddef>

#include <wayfare/map/cell.hpp>

namespace wayfare {

/// A row-major window of the plane: cell c is at (c.y − origin.y)·stride + c.x − origin.x.
struct RasterShape {
  Cell origin;
  std::ptrdiff_t stride = 0;

  [[nodiscard]] std::ptrdiff_t at(const Cell& c) const {
    return (std::ptrdiff_t{c.y} - origin.y) * stride + (std::ptrdiff_t{c.x} - origin.x);
  }
};

}  // namespace wayfare
