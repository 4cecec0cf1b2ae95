#include "plans.hpp"

#include <algorithm>
#include <utility>

#include <wayfare/io/map_image.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/sim/worlds.hpp>

namespace wayfare::examples {
namespace {

Result<sim::PlannedRoute> plan_of_map(const std::string& yaml_path) {
  const auto map = io::read_map(yaml_path);
  if (!map) return map.error();
  sim::CellMask mask{
      static_cast<int>(map->width), static_cast<int>(map->height), map->resolution_m, {}};
  for (std::size_t row = map->height; row-- > 0;) {
    for (std::size_t column = 0; column < map->width; ++column) {
      const float occupancy = map->occupancy[row * map->width + column];
      mask.solid.push_back(occupancy < 0.5F ? 0 : 1);  // NaN is unknown: 1
    }
  }
  auto plan = sim::FloorPlan::from_cells(mask);
  if (!plan) return Error{plan.error().code, plan.error().message, yaml_path};
  return sim::PlannedRoute{std::move(plan).value(), {}};
}

}  // namespace

Result<sim::PlannedRoute> read_any_plan(const std::string& path) {
  if (path.empty()) return sim::read_plan(sim::demo_building(), "the built-in building");
  if (path.ends_with(".yaml")) return plan_of_map(path);
  const auto text = io::read_file(path);
  if (!text) return text.error();
  return sim::read_plan(text->bytes, path);
}

bool is_world(const std::string& name) {
  const auto names = sim::world_names();
  return std::any_of(names.begin(), names.end(), [&](const auto& w) { return w.name == name; });
}

Result<sim::FloorPlan> read_walls(const std::string& world_or_path, std::uint64_t seed) {
  if (is_world(world_or_path)) {
    auto world = sim::make_world(world_or_path, Rng(seed));
    if (!world) return world.error();
    return std::move(world->plan);
  }
  auto planned = read_any_plan(world_or_path);
  if (!planned) return planned.error();
  return std::move(planned->plan);
}

}  // namespace wayfare::examples
