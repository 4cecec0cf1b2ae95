#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <wayfare/core/angle.hpp>

#include "buildings.hpp"

namespace wayfare::examples {

/// What the map's heading may be used for, in the table's order.
[[nodiscard]] const std::vector<std::string>& heading_ways();

struct HeadingErrors {
  double position_m = 0.0;   ///< of the walker by submaps and steps, see rmse_m()
  double heading_deg = 0.0;  ///< of the pedestrian filter's own, root mean square over the scans
  double nees = 0.0;         ///< its square over the variance the filter gives it, mean
};

/// One walk with a gyro of such a bias a second, standard deviation, simulated and followed in each
/// way.
[[nodiscard]] std::vector<HeadingErrors> follow_headings(const Walk& walk, std::uint64_t seed,
                                                         Angle gyro_bias);

}  // namespace wayfare::examples
