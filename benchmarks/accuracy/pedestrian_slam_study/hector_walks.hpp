#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "buildings.hpp"

namespace wayfare::examples {

/// What Hector SLAM may be given of the unit, in the table's order.
[[nodiscard]] const std::vector<std::string>& hector_ways();

/// Errors against the truth over a walk's scans, both started from the same pose; root mean
/// squares. Normalised squared errors a degree of freedom (1 is as sure as it says), NaN where no
/// covariance is given.
struct HectorErrors {
  double position_m = 0.0, heading_deg = 0.0, tilt_deg = 0.0;
  double pose_nees = std::numeric_limits<double>::quiet_NaN();
  double tilt_nees = std::numeric_limits<double>::quiet_NaN();
  double velocity_nees = std::numeric_limits<double>::quiet_NaN();
};

/// One walk, simulated and followed in each way.
[[nodiscard]] std::vector<HectorErrors> follow_by_hector(const Walk& walk, std::uint64_t seed);

}  // namespace wayfare::examples
