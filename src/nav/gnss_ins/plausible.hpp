#pragma once

#include <wayfare/sensors/gnss.hpp>
#include <wayfare/sensors/imu.hpp>

namespace wayfare::nav {

/// Whether a measurement could have been made at all: finite, and no more than a sensor of this
/// kind can tell.
[[nodiscard]] bool plausible(const ImuSample& s);
[[nodiscard]] bool plausible(const RangeEpoch& e);
[[nodiscard]] bool plausible(const GnssFix& f);

}  // namespace wayfare::nav
