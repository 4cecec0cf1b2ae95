#pragma once

// The latest measurement of a sensor in a few hundred bytes of JSON, for status lines.

#include <string>

#include <wayfare/sensors/measurements.hpp>
#include <wayfare/sensors/scans.hpp>

namespace wayfare::logger {

/// {"t":s,"force":[x,y,z],"rate":[x,y,z]} in m/s² and rad/s; null where it is missing.
[[nodiscard]] std::string status_sample(const MargSample& sample);
/// {"t":s,"from_deg":…,"step_deg":…,"cm":[…]}: the nearest return of each of at most 72 sectors;
/// null without one.
[[nodiscard]] std::string status_sample(const LaserScan& scan);
/// {"t":s,"cm":[[x,y,cm/s],…]}: the 24 strongest points.
[[nodiscard]] std::string status_sample(const RadarScan& scan);

}  // namespace wayfare::logger
