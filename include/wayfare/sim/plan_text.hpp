#pragma once

// Floor plans as text a person can draw. The format is described in docs/formats.md.

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/result.hpp>
#include <wayfare/sim/floor_plan.hpp>

namespace wayfare::sim {

/// A plan and the places a robot is to visit in it, metres.
struct PlannedRoute {
  FloorPlan plan;
  std::vector<Eigen::Vector2d> route_m;  ///< empty where the text names none
};

/// Reads a plan: `wall`, `place`, `route` and `metres_per_character` lines, then, after a line
/// `picture`, the drawing ('#' is wall, a letter or digit is a place, ' ' and '.' are free). Errors
/// carry `source` and the line, and name the column where that helps.
[[nodiscard]] Result<PlannedRoute> read_plan(std::string_view text,
                                             std::string_view source = "plan");

/// Walls from a grey picture (rows from the top, one byte a pixel), such as a map image: a pixel
/// darker than `wall_below` is wall.
[[nodiscard]] Result<FloorPlan> plan_from_picture(std::span<const std::uint8_t> pixels, int width,
                                                  int height, double metres_per_pixel,
                                                  std::uint8_t wall_below = 100);

/// The text of the building the demonstration drives through, 60 m x 30 m: a loop of long, nearly
/// featureless corridors, rooms with doors, a hall with pillars, and a route of two rounds.
[[nodiscard]] std::string_view demo_building();

}  // namespace wayfare::sim
