#pragma once

// SLAM by submaps and loop closure (after Hess et al. 2016): every scan is matched to a submap of
// the latest ones on a smooth grid; finished submaps are searched for places seen again by branch
// and bound, in the background; poses of submaps and scans are adjusted together.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/frame.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/graph/pose_graph.hpp>
#include <wayfare/map/multi_resolution_grid.hpp>
#include <wayfare/match/gauss_newton.hpp>
#include <wayfare/motion/motion_noise.hpp>
#include <wayfare/sensors/recording.hpp>
#include <wayfare/slam/scan_outcome.hpp>

namespace wayfare {

struct SubmapSlamOptions {
  Transform2<frame::Base, frame::Laser> T_base_laser{};

  // Points.
  double max_range_m = 30.0;  ///< farther returns are not used; at most 60
  double voxel_m = 0.03;      ///< one point a square of this side is kept; larger: faster, coarser

  // Motion.
  MotionNoise odometry{0.06, 0.50, 0.04, Angle::degrees(3.0), 0.4, 0.2};
  MotionNoise constant_velocity{0.20, 0.50, 0.05, Angle::degrees(8.0), 0.4, 0.2};
  /// Of a gyroscope's turn between two scans: a floor, and its share of the turn.
  Angle gyro_floor = Angle::degrees(0.5);
  double gyro_per_rad = 0.02;
  double search_sigmas = 4.0;  ///< how far a match may be from where motion led

  // Submaps.
  MultiResolutionOptions grid{};
  /// A robot may turn farther from scan to scan than the widest cells lead back.
  GaussNewtonOptions match{.max_iterations = 20, .start_step = Angle::degrees(4)};
  double node_distance_m = 0.4;            ///< travel after which a scan goes into the submaps …
  Angle node_turn = Angle::degrees(20.0);  ///< … or turn
  int submap_nodes = 60;  ///< scans in a finished submap; every half as many a new one begins
  /// A scan's points err together: this many count against the motion.
  double independent_points = 20.0;
  double least_score = 0.1;     ///< agreement in [0, 1] below which motion stands
  double tracked_score = 0.55;  ///< agreement below which places farther off are tried as well …
  double lost_score = 0.50;     ///< … where agreement with a wider field is this at least
  /// So many scans in a row without agreement begin a submap of their own, tied loosely.
  int lost_scans = 5;

  // Loop closures.
  int nodes_between_loops = 3;      ///< a search every so many nodes …
  int loop_latency_scans = 8;       ///< … joined so many scans later, however fast it was
  double loop_gap_travel_m = 6.0;   ///< submaps with less travel since are no loop
  double loop_overlap_m = 2.0;      ///< how far from a submap's scans one may be that shares a view
  double loop_reach_m = 6.0;        ///< farthest search, whatever the uncertainty
  int loop_context_nodes = 8;       ///< nodes before the latest that are matched together with it
  int loops_per_search = 5;         ///< submaps tried at one node, the nearest
  double loop_sigma_m = 0.10;       ///< blur of the field searched
  double loop_score = 0.60;         ///< accepted when the search is narrow (below 1 m) …
  double wide_loop_score = 0.68;    ///< … and when it is wide, where wrong peaks are likelier
  double loop_kernel_sigmas = 1.0;  ///< Cauchy kernel of loop closures; smaller: more suspicious

  // Memory.
  int tables_kept = 12;  ///< finished submaps ready to be searched; others are packed points
  /// Finished submaps kept for loop closures; older ones are forgotten, their path stays where it
  /// is. 0: all.
  int max_submaps = 0;

  /// More than one: loops are searched beside the caller's thread, by one less than this many.
  int threads = 1;
};

/// What is known of the motion up to a scan; whatever is missing is expected to go on as it did.
struct MotionHint {
  std::optional<Transform2<frame::Odom, frame::Base>> odometry{};  ///< at the scan's time
  std::optional<Angle> turn{};  ///< since the scan before, by a gyroscope
};

struct SubmapSlamStatistics {
  std::size_t scans = 0, unmatched_scans = 0, nodes = 0, submaps = 0, forgotten_submaps = 0;
  std::size_t loop_closures = 0, loops_refused = 0, optimisations = 0;
};

/// Where the latest scan was placed, in a frame no loop closure bends.
struct LocalPlacement {
  Transform2<frame::Odom, frame::Base> T_local_base;
  bool matched = false;  ///< false: by motion alone
  double openness = 1;   ///< 0: the scene holds every direction, 1: not at all along one of them
  /// Of the match by the scan's points alone: x, y along the base's axes, m, heading, rad.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  Eigen::Vector3d expected_sigma = Eigen::Vector3d::Zero();  ///< of the pose it was sought about
};

/// The system, fed scan by scan. Not thread-safe; results depend neither on timing nor on threads.
class SubmapSlam {
 public:
  explicit SubmapSlam(const SubmapSlamOptions& options = {});
  ~SubmapSlam();
  SubmapSlam(SubmapSlam&&) noexcept;
  SubmapSlam& operator=(SubmapSlam&&) noexcept;

  /// Takes the next scan and what is known of the way there. Refused as by GraphSlam::add_scan.
  Result<ScanOutcome> add_scan(const LaserScan& scan, const MotionHint& hint = {});

  /// Joins the search under way, looks for loops from the latest scans once more and optimises to
  /// the end; more scans may follow.
  Result<void> finish();

  /// One pose a scan taken, at the scan's own time, by the graph as it is now.
  [[nodiscard]] Trajectory trajectory() const;
  /// Poses of submaps and nodes; loop closures are the edges marked `robust`.
  [[nodiscard]] const PoseGraph2& graph() const;
  [[nodiscard]] const SubmapSlamStatistics& statistics() const;
  [[nodiscard]] const LocalPlacement& local() const;
  /// Of all nodes not forgotten, at the poses they have now.
  [[nodiscard]] OccupancyGrid map(const OccupancyGridOptions& shape = {},
                                  const InverseLidarModel& model = {}) const;
  /// Bytes held by points, grids and tables.
  [[nodiscard]] std::size_t memory_bytes() const;

  /// Everything needed to go on later as if there had been no break.
  [[nodiscard]] std::vector<std::uint8_t> save() const;
  /// Goes on from saved bytes, with the options it was saved under. An Error names the byte where
  /// they are not such a state.
  [[nodiscard]] static Result<SubmapSlam> restore(std::span<const std::uint8_t> bytes,
                                                  const SubmapSlamOptions& options = {});

 private:
  class Engine;
  friend struct SubmapState;
  explicit SubmapSlam(std::unique_ptr<Engine> engine);
  std::unique_ptr<Engine> engine_;
};

/// A whole recording at once.
struct SubmapSlamRun {
  Trajectory trajectory;
  PoseGraph2 graph;
  OccupancyGrid map;
  SubmapSlamStatistics statistics;
  std::size_t refused_scans = 0;
  std::string first_refusal;  ///< why the first of them was
  std::size_t memory_bytes = 0;
  std::vector<std::uint8_t> state;  ///< SubmapSlam::save() at the end
};

/// Runs over `recording` with its odometry, or else its gyroscope where there is one, going on from
/// `saved` where that is not empty. An Error where no scan could be used.
Result<SubmapSlamRun> run_submap_slam(const Recording& recording, SubmapSlamOptions options = {},
                                      const SlamProgress& progress = {},
                                      std::span<const std::uint8_t> saved = {});

}  // namespace wayfare
