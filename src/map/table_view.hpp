#pragma once

// A table and a pose in the form of the interpolating kernels.

#include <wayfare/core/se2.hpp>
#include <wayfare/map/detail/padded_table.hpp>

#include "map/kernels/kernels.hpp"

namespace wayfare::detail {

[[nodiscard]] inline kernels::Field field_of(const PaddedTable& table) {
  return {table.data(), table.stride(), table.width(), table.height()};
}

/// From the points' frame to columns and rows, cell centres at integers.
[[nodiscard]] inline kernels::CellTransform transform_into(const PaddedTable& table,
                                                           const SE2d& T_map_points) {
  const double cells = 1 / table.resolution_m();
  return {static_cast<float>(T_map_points.rotation().cos() * cells),
          static_cast<float>(T_map_points.rotation().sin() * cells),
          static_cast<float>(T_map_points.x() * cells - table.origin().x - 0.5),
          static_cast<float>(T_map_points.y() * cells - table.origin().y - 0.5),
          0,
          0,
          0};
}

}  // namespace wayfare::detail
