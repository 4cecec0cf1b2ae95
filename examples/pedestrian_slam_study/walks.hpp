#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <wayfare/core/result.hpp>

#include "buildings.hpp"

namespace wayfare::examples {

/// The ways to follow a walker, in the table's order.
[[nodiscard]] const std::vector<std::string>& methods();

struct WalkErrors {
  double way_m = 0.0;
  /// Root mean square of the planar distance over the scans' times, both started from the same pose
  /// (Sadruddin 2020, (5.1)); one a method.
  std::vector<double> rmse_m;
  double scale = 1.0;  ///< what feedback made of the steps' length at the end
};

/// One walk, simulated and followed by every method.
[[nodiscard]] WalkErrors follow_walk(const Walk& walk, std::uint64_t seed);

/// Writes what such a walk records: scans and truth as walk.log, the unit's readings as unit.csv.
[[nodiscard]] Result<void> write_walk(const Walk& walk, std::uint64_t seed,
                                      const std::string& folder);

}  // namespace wayfare::examples
