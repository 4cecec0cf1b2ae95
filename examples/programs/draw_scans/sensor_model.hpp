#pragma once

#include <array>

#include <wayfare/core/result.hpp>
#include <wayfare/io/report.hpp>

namespace wayfare::examples {

/// The sensor models of radar_slam with its default parameters, read from the maps and fields that
/// it makes: the occupancy that a beam and detections give the cells along them (Zhang 2020, figure
/// 2.6), and the likelihood of a point over its distance from a wall.
[[nodiscard]] Result<std::array<io::Plot, 2>> sensor_models();

}  // namespace wayfare::examples
