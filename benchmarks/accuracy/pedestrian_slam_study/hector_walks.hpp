#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "buildings.hpp"

namespace wayfare::examples {

/// How Hector SLAM uses the unit, in the order of the table.
[[nodiscard]] const std::vector<std::string>& hector_methods();

/// Errors against the truth over a walk's scans, both started from the same pose; root mean
/// squares. Normalised squared errors per degree of freedom (1 if consistent), NaN without
/// covariance.
struct HectorErrors {
  double position_m = 0.0, heading_deg = 0.0, tilt_deg = 0.0;
  double pose_nees = std::numeric_limits<double>::quiet_NaN();
  double tilt_nees = std::numeric_limits<double>::quiet_NaN();
  double velocity_nees = std::numeric_limits<double>::quiet_NaN();
};

/// One simulated walk, localised by each method.
[[nodiscard]] std::vector<HectorErrors> follow_by_hector(const Walk& walk, std::uint64_t seed);

}  // namespace wayfare::examples
