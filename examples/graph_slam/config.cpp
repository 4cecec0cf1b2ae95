#include "config.hpp"

#include <cmath>
#include <functional>
#include <vector>

#include <nlohmann/json.hpp>

#include <wayfare/io/text_file.hpp>

namespace wayfare::examples {
namespace {

using Json = nlohmann::ordered_json;

/// A field by its name in the file: how it is read, and how it is written. Values are positive.
struct Field {
  const char* name;
  std::function<void(double)> set;
  std::function<Json()> get;
};

Field field(const char* name, double& value) {
  return {name, [&](double v) { value = v; }, [&] { return Json(value); }};
}
Field field(const char* name, int& value) {
  return {name, [&](double v) { value = static_cast<int>(v); }, [&] { return Json(value); }};
}
Field field(const char* name, Angle& value) {
  return {name, [&](double v) { value = Angle::degrees(v); },
          [&] { return Json(std::round(value.degrees() * 1e6) / 1e6); }};
}

std::vector<Field> fields(GraphSlamOptions& o) {
  return {field("max_range_m", o.max_range_m),
          field("point_spacing_m", o.point_spacing_m),
          field("odometry_translation_floor_m", o.odometry.translation_floor_m),
          field("odometry_translation_per_m", o.odometry.translation_per_m),
          field("odometry_heading_floor_deg", o.odometry.heading_floor),
          field("odometry_heading_per_rad", o.odometry.heading_per_rad),
          field("node_distance_m", o.node_distance_m),
          field("node_turn_deg", o.node_turn),
          field("cell_m", o.cell_m),
          field("local_nodes", o.local_nodes),
          field("sharp_nodes", o.sharp_nodes),
          field("local_radius_m", o.local_radius_m),
          field("search_sigma_m", o.search_sigma_m),
          field("sharp_sigma_m", o.sharp_sigma_m),
          field("tracked_score", o.tracked_score),
          field("lost_score", o.lost_score),
          field("nodes_between_loops", o.nodes_between_loops),
          field("loop_gap_nodes", o.loop_gap_nodes),
          field("loop_gap_travel_m", o.loop_gap_travel_m),
          field("loop_overlap_m", o.loop_overlap_m),
          field("loop_reach_m", o.loop_reach_m),
          field("loop_context_nodes", o.loop_context_nodes),
          field("loop_map_nodes", o.loop_map_nodes),
          field("loops_per_search", o.loops_per_search),
          field("loop_score", o.loop_score),
          field("wide_loop_score", o.wide_loop_score),
          field("loop_kernel_sigmas", o.loop_kernel_sigmas)};
}

}  // namespace

Result<GraphSlamOptions> read_config(const std::string& path) {
  const auto file = io::read_file(path);
  if (!file) return file.error();
  const Json json = Json::parse(file->bytes, nullptr, false, true);
  if (!json.is_object()) {
    return Error{ErrorCode::parse, "expected a JSON object of options", path};
  }
  GraphSlamOptions options;
  const std::vector<Field> known = fields(options);
  for (const auto& [key, value] : json.items()) {
    const auto match = std::find_if(known.begin(), known.end(),
                                    [&, name = key](const Field& f) { return f.name == name; });
    if (match == known.end()) {
      return Error{ErrorCode::parse, "unknown option '" + key + "'; --print-config lists them all",
                   path};
    }
    const double number = value.is_number() ? value.get<double>() : std::nan("");
    if (!(number > 0.0 && number < 1e6)) {
      return Error{ErrorCode::parse, "option '" + key + "' must be a positive number", path};
    }
    match->set(number);
  }
  return options;
}

std::string default_config() {
  GraphSlamOptions options;
  Json json;
  for (const Field& f : fields(options)) json[f.name] = f.get();
  return json.dump(2) + "\n";
}

}  // namespace wayfare::examples
