#pragma once

#include <vector>

#include <wayfare/measure/radar_scan.hpp>
#include <wayfare/sim/radar.hpp>

#include "radar_cube.hpp"

namespace wayfare::sim {

/// The firmware's points: constant false alarm rate over range and Doppler, then angles.
[[nodiscard]] std::vector<RadarPoint> detect(const Cube& cube, const RadarParams& params);

}  // namespace wayfare::sim
