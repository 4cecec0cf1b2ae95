// LiDAR graph SLAM on a recorded log.

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

/// Empty if there is none. Rays cross walls in maps of several pieces, or without odometry, only
/// where they are wrong; with odometry, people do the same.
std::string doubt(const GraphSlamRun& slam, bool no_odometry) {
  constexpr double kMostCrossing = 0.08, kMostOfStretch = 0.16;
  const GraphSlamStatistics& s = slam.statistics;
  if (s.pieces_apart > 0)
    return std::to_string(s.pieces_apart) +
           " pieces of the trajectory were not joined; they are drawn beside the map";
  if (!no_odometry && s.pieces < 2) return {};
  const WallCrossings& crossings = slam.crossings;
  if (crossings.share > kMostCrossing || crossings.worst_stretch > kMostOfStretch)
    return eval::fixed(100.0 * crossings.share, 0) + " % of the rays cross walls, " +
           eval::fixed(100.0 * crossings.worst_stretch, 0) +
           " % on the worst stretch: a part of the map is likely wrong";
  return {};
}

Result<LogRun> run(const Recording& recording, const GraphSlamOptions& options,
                   const SlamProgress& progress) {
  auto slam = run_graph_slam(recording, options, progress);
  if (!slam) return slam.error();
  const GraphSlamStatistics& s = slam->statistics;
  Facts facts = {{"graph", size_of(slam->graph)},
                 {"loop closures", accepted_and_refused(s.loop_closures, s.loops_refused)}};
  if (s.pieces > 1)
    facts.emplace_back("pieces", std::to_string(s.pieces) + ", joins " +
                                     accepted_and_refused(s.joins, s.joins_refused));
  if (s.scans_apart > 0)
    facts.emplace_back(
        "not placed", std::to_string(s.scans_apart) + " scans, between pieces, at predicted poses");
  LogRun result = log_run(*slam, std::move(facts), slam->graph);
  result.doubt = doubt(*slam, recording.odometry.empty());
  return result;
}

}  // namespace

int main(int argc, char** argv) {
  GraphSlamOptions options;
  return run_log_program(
      argc, argv,
      {"graph_slam", "graph SLAM",
       "Estimate trajectory and map from a recorded robot log by LiDAR graph SLAM.",
       fields(options),
       [&](const Recording& recording, const SlamArguments& o, const SlamProgress& progress) {
         options.threads = o.threads;
         return run(recording, options, progress);
       }});
}
