// LiDAR graph SLAM on a recorded log: a corrected trajectory, a map and a report out.

#include <string>
#include <vector>

#include "support/log_program.hpp"

namespace {

using namespace wayfare;

std::vector<examples::OptionField> fields(GraphSlamOptions& o) {
  using examples::option_field;
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
          option_field("loop_kernel_sigmas", o.loop_kernel_sigmas)};
}

Result<examples::LogRun> run(const Recording& recording, const GraphSlamOptions& options,
                             const SlamProgress& progress) {
  auto slam = run_graph_slam(recording, options, progress);
  if (!slam) return slam.error();
  const GraphSlamStatistics& s = slam->statistics;
  const std::string loops = std::to_string(s.loop_closures) + " accepted, " +
                            std::to_string(s.loops_refused) + " refused";
  const std::string size = examples::size_of(slam->graph);
  return examples::LogRun{std::move(slam->trajectory), std::move(slam->map),
                          std::move(slam->graph),      s.scans,
                          s.unmatched_scans,           {{"graph", size}, {"loop closures", loops}},
                          slam->refused_scans,         slam->first_refusal};
}

}  // namespace

int main(int argc, char** argv) {
  GraphSlamOptions options;
  return examples::run_log_program(
      argc, argv,
      {"graph_slam", "graph SLAM",
       "Correct the trajectory of a recorded robot log by LiDAR graph SLAM and draw the map.",
       fields(options),
       [&](const Recording& recording, const examples::SlamArguments& o,
           const SlamProgress& progress) {
         options.threads = o.threads;
         return run(recording, options, progress);
       }});
}
