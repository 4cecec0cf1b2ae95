#pragma once

// Floor plans that programs read.

#include <cstdint>
#include <string>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/sim/floor_plan.hpp>

namespace wayfare::examples {

/// A plan as text, or the .yaml file of a map picture, whose unknown cells are walls so that rooms
/// are closed; the built-in building for an empty path. A file that is not there may be meant as a
/// world: the error lists them.
[[nodiscard]] Result<sim::PlannedRoute> read_any_plan(const std::string& path);

/// Whether it is the name of a simulated world.
[[nodiscard]] bool is_world(const std::string& name);

/// The names of the simulated worlds.
[[nodiscard]] std::vector<std::string> world_names();

/// A wrong argument: `word` is neither a file nor one of the worlds `names`.
[[nodiscard]] Error no_such_world(const std::string& word,
                                  const std::vector<std::string>& names = world_names());

/// The walls of a world, made with this seed, or of a plan, in its own frame.
[[nodiscard]] Result<sim::FloorPlan> read_walls(const std::string& world_or_path,
                                                std::uint64_t seed);

}  // namespace wayfare::examples
