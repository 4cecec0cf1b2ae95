#pragma once

// LiDAR graph SLAM (Zhang 2020, chapter 4): scans in, a corrected trajectory, a pose graph and a
// map out.
//
// Every scan is matched against a local map of the latest nodes, starting where odometry says the
// robot is; every so much travel a scan becomes a node, joined to the one before; nodes are matched
// against whatever older part of the map their uncertainty lets them reach, and accepted matches
// become loop closures; the graph is optimised whenever one was found.

#include <cstddef>
#include <memory>
#include <optional>
#include <string>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/frame.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/graph/pose_graph.hpp>
#include <wayfare/map/inverse_lidar.hpp>
#include <wayfare/map/occupancy_grid.hpp>
#include <wayfare/motion/motion_noise.hpp>
#include <wayfare/sensors/recording.hpp>
#include <wayfare/slam/scan_outcome.hpp>

namespace wayfare {

struct GraphSlamOptions {
  Transform2<frame::Base, frame::Laser> T_base_laser{};

  // Points.
  double max_range_m = 30.0;      ///< farther returns are not matched; wide beams blur there
  double point_spacing_m = 0.03;  ///< between neighbouring points; smaller: slower, no sharper

  // Motion.
  MotionNoise odometry{};
  /// Without odometry the robot is expected to go on as it did; twice as wide fits walking pace.
  MotionNoise constant_velocity{0.20, 0.50, 0.05, Angle::degrees(8.0), 0.4, 0.2};

  // Nodes.
  double node_distance_m = 0.25;          ///< travel that makes a node; larger: faster, coarser
  Angle node_turn = Angle::degrees(8.0);  ///< turn that makes a node

  // Local map.
  double cell_m = 0.05;          ///< side of a cell of the local maps
  int local_nodes = 30;          ///< latest nodes in the map the search runs on
  int sharp_nodes = 8;           ///< latest nodes in the map that places the scan exactly
  double local_radius_m = 8.0;   ///< nodes farther from the latest are left out
  double search_sigma_m = 0.10;  ///< blur of the map searched: what attracts from afar
  double sharp_sigma_m = 0.03;   ///< blur of the map refined on: the range finder's own noise
  double tracked_score = 0.55;   ///< mean agreement in [0, 1] below which the search is widened
  double lost_score = 0.50;      ///< below which odometry stands and the edge is loose

  // Loop closures.
  int nodes_between_loops = 3;      ///< a search for loops every so many nodes
  int loop_gap_nodes = 30;          ///< nodes this recent are no loop
  double loop_gap_travel_m = 6.0;   ///< nor are nodes with less travel in between
  double loop_overlap_m = 2.0;      ///< how far apart two nodes that share a view may be
  double loop_reach_m = 6.0;        ///< farthest search, whatever the uncertainty
  int loop_context_nodes = 8;       ///< nodes before the latest that are matched together with it
  int loop_map_nodes = 12;          ///< nodes before and after a candidate that make its map
  int loops_per_search = 5;         ///< candidates tried at one node
  double loop_score = 0.60;         ///< accepted when the search is narrow (below 1 m) …
  double wide_loop_score = 0.68;    ///< … and when it is wide, where wrong peaks are likelier
  double loop_kernel_sigmas = 1.0;  ///< Cauchy kernel of loop closures; smaller: more suspicious

  int threads = 1;  ///< loop candidates matched at a time; the result is the same for any number
};

struct GraphSlamStatistics {
  std::size_t scans = 0;
  std::size_t unmatched_scans = 0;
  std::size_t widened_searches = 0;
  std::size_t loop_closures = 0;
  std::size_t loops_refused = 0;  ///< candidates matched and not believed
  std::size_t optimisations = 0;
};

/// The system, fed scan by scan. Not thread-safe; results do not depend on timing or threads.
class GraphSlam {
 public:
  explicit GraphSlam(const GraphSlamOptions& options = {});
  ~GraphSlam();
  GraphSlam(GraphSlam&&) noexcept;
  GraphSlam& operator=(GraphSlam&&) noexcept;

  /// Takes the next scan and, where there is any, the odometry at its time. A scan without beams,
  /// with other than finite geometry or earlier than the one before is refused with an Error and
  /// changes nothing; one with too few returns is placed by the motion model.
  Result<ScanOutcome> add_scan(const LaserScan& scan,
                               const std::optional<Transform2<frame::Odom, frame::Base>>& odometry);

  /// Optimises to the end; call it after the last scan (and go on feeding afterwards if there are
  /// more).
  Result<void> finish();

  /// One pose a scan taken, at the scan's own time, by the graph as it is now.
  [[nodiscard]] Trajectory trajectory() const;
  /// Node poses and edges; loop closures are the edges marked `robust`.
  [[nodiscard]] const PoseGraph2& graph() const;
  [[nodiscard]] const GraphSlamStatistics& statistics() const;
  /// The map of all nodes' scans at the poses they have now.
  [[nodiscard]] OccupancyGrid map(const OccupancyGridOptions& shape = {},
                                  const InverseLidarModel& model = {}) const;

 private:
  class Engine;
  std::unique_ptr<Engine> engine_;
};

/// A whole recording at once.
struct GraphSlamRun {
  Trajectory trajectory;
  PoseGraph2 graph;
  OccupancyGrid map;
  GraphSlamStatistics statistics;
  std::size_t refused_scans = 0;
  std::string first_refusal;  ///< why the first of them was
};

/// Runs graph SLAM over `recording` (odometry interpolated at the scans' times). An Error where no
/// scan could be used.
Result<GraphSlamRun> run_graph_slam(const Recording& recording, GraphSlamOptions options = {},
                                    const SlamProgress& progress = {});

}  // namespace wayfare
