#pragma once

// LiDAR graph SLAM (Zhang 2020, chapter 4): takes scans, gives a corrected trajectory, a pose graph
// and a map.
//
// Every scan is matched to a local map of the latest nodes, starting at the pose predicted from
// odometry. After a set travelled distance a scan becomes a node, joined to the previous one. Nodes
// are matched to the older parts of the map within their position uncertainty; accepted matches
// become loop closures, after which the graph is optimised. Where tracking is lost or odometry
// leaps, a new piece of the trajectory begins beside the map, and is joined to it once several
// loops found without a prior pose agree.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/detail/owned.hpp>
#include <wayfare/core/frame.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/graph/pose_graph.hpp>
#include <wayfare/map/inverse_lidar_model.hpp>
#include <wayfare/map/occupancy_grid.hpp>
#include <wayfare/motion/motion_noise.hpp>
#include <wayfare/sensors/recording.hpp>
#include <wayfare/slam/scan_outcome.hpp>

namespace wayfare {

/// Negative counts are taken as zero.
struct GraphSlamOptions {
  Transform2<frame::Base, frame::Laser> T_base_laser{};  ///< mounting of the laser

  // Points.
  double max_range_m = 30.0;  ///< farther returns are not matched: the beam footprint is too wide
  double point_spacing_m = 0.03;  ///< between neighbouring points; smaller is slower, not sharper

  // Motion.
  MotionNoise odometry{};  ///< noise of odometry between scans
  /// Noise of the constant-velocity prediction used without odometry; twice as wide fits walking
  /// pace.
  MotionNoise constant_velocity{0.20, 0.50, 0.05, Angle::degrees(8.0), 0.4, 0.2};

  // Nodes.
  double node_distance_m = 0.25;          ///< travel between nodes; larger: faster, coarser
  Angle node_turn = Angle::degrees(8.0);  ///< heading change between nodes

  // Local map.
  double cell_m = 0.05;          ///< cell side of the local maps
  int local_nodes = 30;          ///< latest nodes in the search map
  int sharp_nodes = 8;           ///< latest nodes in the refinement map
  double local_radius_m = 8.0;   ///< nodes farther from the latest are left out
  double search_sigma_m = 0.10;  ///< blur of the search map: sets the range of attraction
  double sharp_sigma_m = 0.03;   ///< blur of the refinement map: the range finder's own noise
  double tracked_score = 0.55;   ///< mean agreement in [0, 1] below which the search is widened
  double lost_score = 0.50;      ///< below it the odometry pose is kept and the edge is weak
  /// After this number of consecutive scans without agreement a new piece of the trajectory begins.
  int lost_scans = 5;
  int lost_scans_without_odometry = 2;  ///< the same without odometry

  // Loop closures.
  int nodes_between_loops = 5;      ///< nodes between searches for loops
  int loop_gap_nodes = 30;          ///< the latest nodes, which are no loop candidates
  double loop_gap_travel_m = 6.0;   ///< least travel between the nodes of a loop
  double loop_overlap_m = 2.0;      ///< greatest distance of two nodes with a common view
  double loop_reach_m = 6.0;        ///< upper limit of the search radius
  int loop_context_nodes = 8;       ///< nodes before the latest that are matched together with it
  int loop_map_nodes = 12;          ///< nodes before and after a candidate in its map
  int loops_per_search = 5;         ///< candidates matched for one node
  double loop_score = 0.60;         ///< least score of a narrow search (below 1 m) …
  double wide_loop_score = 0.68;    ///< … and of a wide one, where false maxima are likelier
  double loop_kernel_sigmas = 1.0;  ///< Cauchy kernel of loop closures; smaller: more robust

  // Known area.
  /// Number of nodes from which on those of known area are merged into older ones, so that their
  /// number, and time and memory of a scan, grow with the area and not with time; 0: never.
  int nodes_before_merging = 0;
  double merge_distance_m = 1.0;            ///< of a node from an older one of an earlier visit
  Angle merge_turn = Angle::degrees(30.0);  ///< the same, heading

  int threads = 1;  ///< loop candidates matched in parallel; any number gives the same result
};

/// Counts of scans, searches and loop closures.
struct GraphSlamStatistics : PieceStatistics {
  std::size_t scans = 0;             ///< accepted
  std::size_t unmatched_scans = 0;   ///< kept at their predicted pose
  std::size_t widened_searches = 0;  ///< scans matched in the wider window
  std::size_t loop_closures = 0;     ///< accepted
  std::size_t loops_refused = 0;     ///< candidates matched and rejected
  std::size_t optimisations = 0;     ///< of the graph
  MatcherErrors matcher_errors;      ///< of the matcher's Errors and invalid results
};

/// Processes one scan at a time. Not thread-safe; results do not depend on timing or threads.
class GraphSlam {
 public:
  /// Without scans.
  explicit GraphSlam(const GraphSlamOptions& options = {});

  /// Processes the next scan with the odometry at its time, if any. Returns an Error and changes
  /// nothing for a scan without beams, with non-finite geometry, or earlier than the previous one,
  /// and for odometry that is not finite or farther than 10 000 km from its origin. Odometry that
  /// leaps by more than 10 km, or whose noise by the options is NaN, counts as missing. A scan with
  /// too few returns gets the pose predicted by the motion model.
  Result<ScanOutcome> add_scan(const LaserScan& scan,
                               const std::optional<Transform2<frame::Odom, frame::Base>>& odometry);

  /// Optimises to convergence; call it after the last scan. More scans may follow. The first pose
  /// stays; where nodes are merged, the map as a whole does, by least squares.
  Result<void> finish();

  /// One pose per accepted scan, at the scan's own time, by the current graph.
  [[nodiscard]] Trajectory trajectory() const;
  /// Node poses and edges; loop closures are the edges marked `robust`.
  [[nodiscard]] const PoseGraph2& graph() const;
  /// Counts so far.
  [[nodiscard]] const GraphSlamStatistics& statistics() const;
  /// The map of all nodes' scans at their current poses.
  [[nodiscard]] OccupancyGrid map(const OccupancyGridOptions& shape = {},
                                  const InverseLidarModel& model = {}) const;
  /// Of every third node's rays through the walls of its map.
  [[nodiscard]] WallCrossings wall_crossings(const OccupancyGrid& map) const;

  /// The complete state, to continue later as if without interruption.
  [[nodiscard]] std::vector<std::uint8_t> save() const;
  /// Continues from a saved state, with the options it was saved under. Errors name the byte:
  /// another format, damage (by the digest at the end), values that no map has.
  [[nodiscard]] static Result<GraphSlam> restore(std::span<const std::uint8_t> bytes,
                                                 const GraphSlamOptions& options = {});

 private:
  class Engine;
  detail::Owned<Engine> engine_;
};

/// Results for a whole recording.
struct GraphSlamRun {
  Trajectory trajectory;           ///< one pose per accepted scan
  PoseGraph2 graph;                ///< at the end
  OccupancyGrid map;               ///< of all nodes' scans
  GraphSlamStatistics statistics;  ///< counts
  std::size_t refused_scans = 0;   ///< by add_scan
  std::string first_refusal;       ///< reason for the first of them
  WallCrossings crossings;         ///< by the map
};

/// Runs graph SLAM over `recording`, with odometry interpolated at the scans' times, continuing
/// from `saved` if not empty; `state`, if given, becomes GraphSlam::save() after the last scan.
/// Returns an Error if no scan could be used.
Result<GraphSlamRun> run_graph_slam(const Recording& recording, GraphSlamOptions options = {},
                                    const SlamProgress& progress = {},
                                    std::span<const std::uint8_t> saved = {},
                                    std::vector<std::uint8_t>* state = nullptr);

}  // namespace wayfare
