#pragma once

#include <wayfare/sensors/gnss.hpp>
#include <wayfare/sensors/imu.hpp>

namespace wayfare::nav {

/// Whether a measurement is finite and within the range of any sensor of its kind.
[[nodiscard]] bool plausible(const ImuSample& s);
[[nodiscard]] bool plausible(const RangeEpoch& e);
[[nodiscard]] bool plausible(const GnssFix& f);

}  // namespace wayfare::nav
