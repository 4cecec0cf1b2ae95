#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "buildings.hpp"

namespace wayfare::examples {

/// The methods, in the order of the table.
[[nodiscard]] const std::vector<std::string>& methods();

struct WalkErrors {
  double length_m = 0.0;
  std::vector<double> rmse_m;  ///< of each method, see rmse_m()
  double scale = 1.0;          ///< of the step length by feedback, at the end
};

/// One simulated walk, localised by every method.
[[nodiscard]] WalkErrors follow_walk(const Walk& walk, std::uint64_t seed);

}  // namespace wayfare::examples
