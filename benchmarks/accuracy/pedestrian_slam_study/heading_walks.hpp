#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <wayfare/core/angle.hpp>

#include "buildings.hpp"

namespace wayfare::examples {

/// What the map's heading corrects, in the order of the table.
[[nodiscard]] const std::vector<std::string>& heading_methods();

struct HeadingErrors {
  double position_m = 0.0;   ///< by submaps and steps, see rmse_m()
  double heading_deg = 0.0;  ///< of the pedestrian filter, root mean square over the scans
  double nees = 0.0;         ///< mean of the squared heading error over the filter's variance
};

/// One simulated walk, localised by each method. `gyro_bias`: standard deviation, per second.
[[nodiscard]] std::vector<HeadingErrors> follow_headings(const Walk& walk, std::uint64_t seed,
                                                         Angle gyro_bias);

}  // namespace wayfare::examples
