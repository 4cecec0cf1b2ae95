#include "option_fields.hpp"

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include <wayfare/io/text_file.hpp>

#include "json_object.hpp"

namespace wayfare::examples {

using Json = nlohmann::ordered_json;

OptionField option_field(const char* name, double& value) {
  return {name, [&](double v) { value = v; }, [&] { return value; }};
}
OptionField option_field(const char* name, int& value) {
  return {name, [&](double v) { value = static_cast<int>(v); },
          [&] { return static_cast<double>(value); }, true};
}
OptionField option_field(const char* name, std::size_t& value) {
  return {name, [&](double v) { value = static_cast<std::size_t>(v); },
          [&] { return static_cast<double>(value); }, true};
}
OptionField option_field(const char* name, Angle& value) {
  return {name, [&](double v) { value = Angle::degrees(v); },
          [&] { return std::round(value.degrees() * 1e6) / 1e6; }};
}

Result<void> read_option_fields(const std::string& path, const std::vector<OptionField>& known) {
  const auto file = io::read_file(path);
  if (!file) return file.error();
  const auto json = parse_json_object<Json>(file->bytes, path);
  if (!json) return json.error();
  const auto error = [&](const std::string& what) { return Error{ErrorCode::parse, what, path}; };
  for (const auto& [key, value] : json->items()) {
    const auto match =
        std::find_if(known.begin(), known.end(),
                     [&, name = key](const OptionField& f) { return f.name == name; });
    if (match == known.end())
      return error("unknown option '" + key + "'; --print-config lists all options");
    const double number = value.is_number() ? value.get<double>() : std::nan("");
    if (!(number > 0.0 && number < 1e6))
      return error("option '" + key + "' must be a positive number");
    if (match->whole && number < 1.0) return error("option '" + key + "' must be at least 1");
    match->set(number);
  }
  return {};
}

std::string option_fields_text(const std::vector<OptionField>& fields) {
  Json json;
  for (const OptionField& f : fields)
    json[f.name] = f.whole ? Json(static_cast<int>(f.get())) : Json(f.get());
  return json.dump(2) + "\n";
}

std::vector<OptionField> submap_slam_fields(SubmapSlamOptions& o) {
  return {option_field("max_range_m", o.max_range_m),
          option_field("voxel_m", o.voxel_m),
          option_field("odometry_translation_floor_m", o.odometry.translation_floor_m),
          option_field("odometry_translation_per_m", o.odometry.translation_per_m),
          option_field("odometry_heading_floor_deg", o.odometry.heading_floor),
          option_field("odometry_heading_per_rad", o.odometry.heading_per_rad),
          option_field("gyro_floor_deg", o.gyro_floor),
          option_field("gyro_per_rad", o.gyro_per_rad),
          option_field("search_sigmas", o.search_sigmas),
          option_field("cell_m", o.grid.finest.resolution_m),
          option_field("levels", o.grid.levels),
          option_field("p_free", o.grid.model.p_free),
          option_field("p_hit", o.grid.model.p_hit),
          option_field("unknown_probability", o.grid.unknown_probability),
          option_field("max_iterations", o.match.max_iterations),
          option_field("start_step_deg", o.match.start_step),
          option_field("node_distance_m", o.node_distance_m),
          option_field("node_turn_deg", o.node_turn),
          option_field("submap_nodes", o.submap_nodes),
          option_field("independent_points", o.independent_points),
          option_field("least_score", o.min_score),
          option_field("tracked_score", o.tracked_score),
          option_field("lost_score", o.lost_score),
          option_field("lost_scans", o.lost_scans),
          option_field("lost_scans_without_odometry", o.lost_scans_without_odometry),
          option_field("nodes_between_loops", o.nodes_between_loops),
          option_field("loop_latency_scans", o.loop_latency_scans),
          option_field("loop_gap_travel_m", o.loop_gap_travel_m),
          option_field("loop_overlap_m", o.loop_overlap_m),
          option_field("loop_reach_m", o.loop_reach_m),
          option_field("loop_context_nodes", o.loop_context_nodes),
          option_field("loops_per_search", o.loops_per_search),
          option_field("loop_cell_m", o.loop_cell_m),
          option_field("loop_sigma_m", o.loop_sigma_m),
          option_field("loop_score", o.loop_score),
          option_field("wide_loop_score", o.wide_loop_score),
          option_field("loop_kernel_sigmas", o.loop_kernel_sigmas),
          option_field("drift_m_per_sqrt_m", o.drift.m_per_sqrt_m),
          option_field("drift_turn_deg_per_sqrt_m", o.drift.turn_per_sqrt_m),
          option_field("tables_kept", o.tables_kept),
          option_field("max_submaps", o.max_submaps),
          option_field("max_forgotten_poses", o.max_forgotten_poses)};
}

Result<void> check_grid(const MultiResolutionOptions& grid) {
  const auto probability = [](double p) { return p > 0 && p < 1; };
  if (grid.levels <= 8 && probability(grid.model.p_free) && probability(grid.model.p_hit) &&
      grid.unknown_probability <= 1)
    return {};
  return Error{ErrorCode::parse, "at most 8 levels are allowed, and probabilities below 1"};
}

/// Also of the fields that loops are searched in: see LikelihoodFieldOptions for their kernel.
Result<void> check_submap_slam(const SubmapSlamOptions& o) {
  constexpr double kMostCells = 16.0;  // 30 at the kernel's end
  if (auto ok = check_grid(o.grid); !ok) return ok;
  if (o.loop_sigma_m <= kMostCells * std::min(o.loop_cell_m, o.grid.finest.resolution_m)) return {};
  return Error{ErrorCode::parse, "loop_sigma_m may be at most 16 cells, of loop_cell_m and cell_m"};
}

}  // namespace wayfare::examples
