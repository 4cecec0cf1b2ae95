#include "plans.hpp"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include <wayfare/io/map_image.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/sim/worlds.hpp>

#include "command_line.hpp"

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
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) return no_such_world(path);
  if (path.ends_with(".yaml")) return plan_of_map(path);
  const auto text = io::read_file(path);
  if (!text) return text.error();
  return sim::read_plan(text->bytes, path);
}

bool is_world(const std::string& name) {
  const auto names = sim::world_names();
  return std::any_of(names.begin(), names.end(), [&](const auto& w) { return w.name == name; });
}

std::vector<std::string> world_names() {
  std::vector<std::string> names;
  for (const sim::WorldName& world : sim::world_names()) names.emplace_back(world.name);
  return names;
}

Error no_such_world(const std::string& word, const std::vector<std::string>& names) {
  std::string message = word + ": is neither a file nor a world:";
  for (const std::string& name : names) message += ' ' + name + (&name == &names.back() ? "" : ",");
  const std::string meant = nearest(word, names);
  return bad_use(message + (meant.empty() ? "" : "; did you mean " + meant + "?"));
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
