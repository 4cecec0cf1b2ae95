// LiDAR graph SLAM on a recorded log.

#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "support/slam_program.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

std::vector<OptionField> fields(GraphSlamOptions& o) {
  return {option_field("max_range_m", o.max_range_m),
          option_field("point_spacing_m", o.point_spacing_m),
          option_field("odometry_translation_floor_m", o.odometry.translation_floor_m),
          option_field("odometry_translation_per_m", o.odometry.translation_per_m),
          option_field("odometry_heading_floor_deg", o.odometry.heading_floor),
          option_field("odometry_heading_per_rad", o.odometry.heading_per_rad),
          option_field("node_distance_m", o.node_distance_m),
          option_field("node_turn_deg", o.node_turn),
          option_field("cell_m", o.cell_m),
          option_field("local_nodes", o.local_nodes),
          option_field("sharp_nodes", o.sharp_nodes),
          option_field("local_radius_m", o.local_radius_m),
          option_field("search_sigma_m", o.search_sigma_m),
          option_field("sharp_sigma_m", o.sharp_sigma_m),
          option_field("tracked_score", o.tracked_score),
          option_field("lost_score", o.lost_score),
          option_field("lost_scans", o.lost_scans),
          option_field("lost_scans_without_odometry", o.lost_scans_without_odometry),
          option_field("nodes_between_loops", o.nodes_between_loops),
          option_field("loop_gap_nodes", o.loop_gap_nodes),
          option_field("loop_gap_travel_m", o.loop_gap_travel_m),
          option_field("loop_overlap_m", o.loop_overlap_m),
          option_field("loop_reach_m", o.loop_reach_m),
          option_field("loop_context_nodes", o.loop_context_nodes),
          option_field("loop_map_nodes", o.loop_map_nodes),
          option_field("loops_per_search", o.loops_per_search),
          option_field("loop_score", o.loop_score),
          option_field("wide_loop_score", o.wide_loop_score),
          option_field("loop_kernel_sigmas", o.loop_kernel_sigmas),
          option_field("nodes_before_merging", o.nodes_before_merging),
          option_field("merge_distance_m", o.merge_distance_m),
          option_field("merge_turn_deg", o.merge_turn)};
}

Result<LogRun> run(GraphSlamOptions options, const StateFiles& files, const Recording& recording,
                   const SlamArguments& arguments, const SlamProgress& progress) {
  const auto saved = files.read(arguments.write());
  if (!saved) return saved.error();
  options.threads = arguments.threads;
  std::vector<std::uint8_t> state;
  auto slam =
      run_graph_slam(recording, options, progress, *saved, files.to.empty() ? nullptr : &state);
  if (!slam) return files.named(slam.error());
  if (auto ok = files.write(state, arguments.write()); !ok) return ok.error();
  const GraphSlamStatistics& s = slam->statistics;
  Facts facts = {{"graph", size_of(slam->graph)},
                 {"loop closures", accepted_and_refused(s.loop_closures, s.loops_refused)}};
  return log_run_of_pieces(*slam, std::move(facts));
}

}  // namespace

int main(int argc, char** argv) {
  GraphSlamOptions options;
  StateFiles files;
  return run_log_program(
      argc, argv,
      {"graph_slam",
       "graph SLAM",
       "Estimate trajectory and map from a recorded robot log by LiDAR graph SLAM.",
       fields(options),
       std::bind_front(run, std::cref(options), std::cref(files)),
       {},
       [&](CommandLine& app) { files.add_options(app); }});
}
