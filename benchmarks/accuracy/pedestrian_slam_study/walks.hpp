#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "buildings.hpp"

namespace wayfare::examples {

/// The ways to follow a walker, in the table's order.
[[nodiscard]] const std::vector<std::string>& methods();

struct WalkErrors {
  double way_m = 0.0;
  /// See rmse_m(); one a method.
  std::vector<double> rmse_m;
  double scale = 1.0;  ///< what feedback made of the steps' length at the end
};

/// One walk, simulated and followed by every method.
[[nodiscard]] WalkErrors follow_walk(const Walk& walk, std::uint64_t seed);

}  // namespace wayfare::examples
