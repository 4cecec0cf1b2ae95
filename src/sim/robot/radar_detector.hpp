#pragma once

#include <vector>

#include <wayfare/sensors/radar_scan.hpp>
#include <wayfare/sim/radar.hpp>

#include "sim/robot/radar_cube.hpp"

namespace wayfare::sim {

/// The firmware's detector: constant false alarm rate over range and Doppler, then angles.
[[nodiscard]] std::vector<RadarPoint> detect(const Cube& cube, const RadarParams& params);

}  // namespace wayfare::sim
