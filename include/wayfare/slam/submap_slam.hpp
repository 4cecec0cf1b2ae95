#pragma once

// SLAM with submaps and loop closure (after Hess et al. 2016): every scan is matched to a submap of
// the latest scans on a smooth grid, or by another matcher; finished submaps are searched for loop
// closures by branch and bound in the background; poses of submaps and scans are optimised
// together. Where tracking is lost a new piece of the trajectory begins beside the map, and is
// joined to it as in graph SLAM.

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/detail/owned.hpp>
#include <wayfare/core/frame.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/graph/pose_graph.hpp>
#include <wayfare/map/probability_grid.hpp>
#include <wayfare/match/gauss_newton.hpp>
#include <wayfare/motion/differential_drive_model.hpp>
#include <wayfare/sensors/recording.hpp>
#include <wayfare/slam/detail/matched_map.hpp>
#include <wayfare/slam/scan_outcome.hpp>

namespace wayfare {

/// Negative counts are taken as zero.
struct SubmapSlamOptions {
  Transform2<frame::Base, frame::Laser> T_base_laser{};  ///< mounting of the laser

  // Points.
  double max_range_m = 30.0;  ///< farther returns are not used; at most 60
  double voxel_m = 0.03;      ///< one point per square of this side; larger: faster, coarser

  // Motion.
  /// Noise of odometry between scans.
  MotionNoise odometry{0.06, 0.50, 0.04, Angle::degrees(3.0), 0.4, 0.2};
  /// Without odometry.
  MotionNoise constant_velocity{0.20, 0.50, 0.05, Angle::degrees(8.0), 0.4, 0.2};
  /// Standard deviation of a gyroscope's heading change between scans: floor, and share of the
  /// change.
  Angle gyro_floor = Angle::degrees(0.5);
  double gyro_per_rad = 0.02;  ///< of the change
  double search_sigmas = 4.0;  ///< half width of the search window, in σ of the prediction

  // Submaps.
  MultiResolutionOptions grid{};  ///< grids of a submap and inverse sensor model
  /// Heading step of the start poses: between scans a robot may turn beyond the basin of
  /// convergence.
  GaussNewtonOptions match{.max_iterations = 20, .start_step = Angle::degrees(4)};
  double node_distance_m = 0.4;  ///< travel after which a scan is added to the submaps …
  Angle node_turn = Angle::degrees(20.0);  ///< … or heading change
  int submap_nodes = 60;  ///< scans in a finished submap; a new one starts after every half of them
  /// Errors of a scan's points are correlated: effective number of points against the prior.
  double independent_points = 20.0;
  double min_score = 0.1;       ///< agreement in [0, 1] below which the predicted pose is kept
  double tracked_score = 0.55;  ///< agreement below which a wider search follows …
  double lost_score = 0.50;     ///< … whose agreement with a broader field must reach this
  /// After this number of consecutive scans without agreement a new piece of the trajectory begins;
  /// where they have too few points, a new submap, weakly joined.
  int lost_scans = 5;
  /// The same without odometry, where the agreement must be as usual; 0: no pieces then.
  int lost_scans_without_odometry = 2;

  // Loop closures.
  int nodes_between_loops = 5;      ///< nodes between searches …
  int loop_latency_scans = 8;       ///< … whose results are used this number of scans later
  double loop_gap_travel_m = 6.0;   ///< least travel since a submap that closes a loop
  double loop_overlap_m = 2.0;      ///< greatest distance from a submap's scans with a common view
  double loop_reach_m = 6.0;        ///< upper limit of the search radius
  int loop_context_nodes = 8;       ///< nodes before the latest that are matched together with it
  int loops_per_search = 5;         ///< submaps matched for one node, the nearest
  double loop_cell_m = 0.05;        ///< cells of the field searched; larger: faster, less memory
  double loop_sigma_m = 0.10;       ///< blur of that field
  double loop_score = 0.60;         ///< least score of a narrow search (below 1 m) …
  double wide_loop_score = 0.68;    ///< … and of a wide one, where false maxima are likelier
  double loop_kernel_sigmas = 1.0;  ///< Cauchy kernel of loop closures; smaller: more robust

  /// Errors of the path that loops do not correct: for `covariance` alone.
  PathDrift drift{};

  // Memory.
  int tables_kept = 5;  ///< finished submaps with search tables in memory; others are packed points
  /// Finished submaps kept for loop closures; older ones are dropped and their trajectory is fixed.
  /// 0: all.
  int max_submaps = 0;
  /// Poses of scans kept in the trajectory though their submaps were dropped, the latest ones. 0:
  /// all. With both limits a long run needs no more memory than a short one.
  int max_forgotten_poses = 0;

  /// More than one: loops are searched in the background by this number less one.
  int threads = 1;
};

/// Motion up to a scan; constant velocity replaces what is missing.
struct MotionHint {
  std::optional<Transform2<frame::Odom, frame::Base>> odometry{};  ///< at the scan's time
  std::optional<Angle> turn{};  ///< heading change since the previous scan, by a gyroscope
  /// Odometry was set, or the robot carried, since the previous scan. Where `odometry` moves
  /// farther than a robot drives it need not be told.
  bool leaped = false;
};

/// Counts of scans, submaps and loop closures.
struct SubmapSlamStatistics : PieceStatistics {
  std::size_t scans = 0,          ///< accepted
      unmatched_scans = 0,        ///< kept at their prediction
      nodes = 0,                  ///< in the graph
      submaps = 0,                ///< begun
      forgotten_submaps = 0;      ///< dropped by max_submaps
  std::size_t loop_closures = 0,  ///< accepted
      loops_refused = 0,          ///< candidates matched and rejected
      optimisations = 0;          ///< of the graph
  MatcherErrors matcher_errors;   ///< of the matcher's Errors and invalid results
};

/// Pose of the latest scan, in a frame that loop closures do not deform.
struct LocalPlacement {
  Transform2<frame::Odom, frame::Base> T_local_base;  ///< continuous
  bool matched = false;                               ///< false: predicted
  double openness = 1;  ///< degeneracy; 0: all directions constrained, 1: one direction not at all
  /// Of the match, from the scan's points alone: x, y along the base's axes, m, heading, rad.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  Eigen::Vector3d predicted_sigma = Eigen::Vector3d::Zero();  ///< of the predicted pose
};

/// Submap SLAM by any matcher, as made by a BasicSubmapSlam. Processes one scan at a time. Not
/// thread-safe; results depend neither on timing nor on threads.
class SubmapSlamSystem {
 public:
  /// Processes the next scan with the motion up to it, if known. Errors as GraphSlam::add_scan;
  /// also for a match that is not valid (see MatcherErrors), which changes nothing. Where the
  /// matcher returns an Error, or a pose far outside the window, the scan keeps its predicted one.
  Result<ScanOutcome> add_scan(const LaserScan& scan, const MotionHint& hint = {});

  /// Joins the running search, searches for loops from the latest scans once more and optimises to
  /// convergence; more scans may follow.
  Result<void> finish();

  /// One pose per accepted scan, at the scan's own time, by the current graph.
  [[nodiscard]] Trajectory trajectory() const;
  /// Poses of submaps and nodes; loop closures are the edges marked `robust`.
  [[nodiscard]] const PoseGraph2& graph() const;
  /// Counts so far.
  [[nodiscard]] const SubmapSlamStatistics& statistics() const;
  /// After `restore` the pose alone is known until the next scan.
  [[nodiscard]] const LocalPlacement& local() const;
  /// Of the latest pose relative to the first one kept in its part of the map, a right
  /// perturbation: x and y along the base's axes, m², and heading, rad². It is that of the path to
  /// the latest node by `SubmapSlamOptions::drift` and the loops closed, then that of the last
  /// match and of the motion since. Found again for each node, in a time that grows with the graph.
  /// After `restore` from the next match on.
  [[nodiscard]] Eigen::Matrix3d covariance() const;
  /// Of all nodes kept, at their current poses.
  [[nodiscard]] OccupancyGrid map(const OccupancyGridOptions& shape = {},
                                  const InverseLidarModel& model = {}) const;
  /// The same of the part of the map that the latest scan belongs to: of its piece of the
  /// trajectory and those joined to it.
  [[nodiscard]] OccupancyGrid latest_part(const OccupancyGridOptions& shape = {},
                                          const InverseLidarModel& model = {}) const;
  /// The poses of scans in that part.
  [[nodiscard]] Trajectory latest_trajectory() const;
  /// Of every third node's rays through the walls of its map.
  [[nodiscard]] WallCrossings wall_crossings(const OccupancyGrid& map) const;
  /// Bytes used by points, grids and tables.
  [[nodiscard]] std::size_t memory_bytes() const;
  /// Drops the search tables of finished submaps, which are made again when needed.
  void drop_tables();

  /// The complete state, to continue later as if without interruption.
  [[nodiscard]] std::vector<std::uint8_t> save() const;

 protected:
  /// Scans of the unfinished submap are matched by `options.match`, loops on a smooth grid.
  explicit SubmapSlamSystem(const SubmapSlamOptions& options);
  /// With the maps of a matcher.
  SubmapSlamSystem(const SubmapSlamOptions& options, detail::SubmapMaps maps);
  /// The state that `save` returned. Errors: those of BasicSubmapSlam::restore.
  Result<void> load(std::span<const std::uint8_t> bytes);

 private:
  class Engine;
  friend struct SubmapState;
  detail::Owned<Engine> engine_;
};

/// Submap SLAM by a matcher `M` that makes its own maps (MappingMatcher), or matches in the tables
/// of occupancy probabilities that the system keeps (`M::Map` is ProbabilityPyramid). It matches
/// scans to the unfinished submap, whose map is made again when a scan was added, and refines
/// loops, in several threads by a copy each; it must not depend on earlier matches. The wide
/// searches before are the library's. `SubmapSlamOptions::match` is not used.
///
/// A match without a covariance counts as exact to the tolerance of the graph's edges; one without
/// a scene constraint takes it from the covariance.
template <SlamMatcher M>
class BasicSubmapSlam : public SubmapSlamSystem {
 public:
  /// With the matcher of the options.
  explicit BasicSubmapSlam(
      const SubmapSlamOptions& options = {}) requires std::same_as<M, GaussNewtonMatcher>
      : SubmapSlamSystem(options) {}
  /// Copies the matcher.
  explicit BasicSubmapSlam(const M& matcher, const SubmapSlamOptions& options = {})
      : SubmapSlamSystem(options, detail::submap_maps(matcher, matcher, options.grid,
                                                      options.T_base_laser.raw().translation())) {}

  /// Continues from a saved state, with the options and the matcher it was saved under. An Error
  /// names the byte at which it is not valid: damaged (by its digest), of a matcher of another name
  /// (see SlamMatcher), or with values that no map has. States of the earlier format, which names
  /// no matcher, are read by any.
  [[nodiscard]] static Result<BasicSubmapSlam> restore(
      std::span<const std::uint8_t> bytes,
      const SubmapSlamOptions& options = {}) requires std::same_as<M, GaussNewtonMatcher> {
    return BasicSubmapSlam(options).loaded(bytes);
  }
  /// With the matcher the state was saved under.
  [[nodiscard]] static Result<BasicSubmapSlam> restore(std::span<const std::uint8_t> bytes,
                                                       const M& matcher,
                                                       const SubmapSlamOptions& options = {}) {
    return BasicSubmapSlam(matcher, options).loaded(bytes);
  }

 private:
  [[nodiscard]] Result<BasicSubmapSlam> loaded(std::span<const std::uint8_t> bytes) && {
    if (auto ok = load(bytes); !ok) return ok.error();
    return std::move(*this);
  }
};

using SubmapSlam = BasicSubmapSlam<GaussNewtonMatcher>;  ///< by Gauss-Newton matching in the grids

/// Results for a whole recording.
struct SubmapSlamRun {
  Trajectory trajectory;            ///< one pose per accepted scan
  PoseGraph2 graph;                 ///< of submaps and nodes
  OccupancyGrid map;                ///< of all nodes kept
  SubmapSlamStatistics statistics;  ///< counts
  std::size_t refused_scans = 0;    ///< by add_scan
  std::string first_refusal;        ///< reason for the first of them
  std::size_t memory_bytes = 0;     ///< at the end
  WallCrossings crossings;          ///< by the map
  std::vector<std::uint8_t> state;  ///< SubmapSlam::save() at the end
};

/// Runs over `recording` with its odometry, or else its gyroscope if it has one, continuing from
/// `saved` if not empty. Returns an Error if no scan could be used.
Result<SubmapSlamRun> run_submap_slam(const Recording& recording, SubmapSlamOptions options = {},
                                      const SlamProgress& progress = {},
                                      std::span<const std::uint8_t> saved = {});

namespace detail {
Result<SubmapSlamRun> run(SubmapSlamSystem& slam, const Recording& recording,
                          const SlamProgress& progress);
}  // namespace detail

/// The same by a matcher.
template <SlamMatcher M>
Result<SubmapSlamRun> run_submap_slam(const Recording& recording, const M& matcher,
                                      SubmapSlamOptions options = {},
                                      const SlamProgress& progress = {},
                                      std::span<const std::uint8_t> saved = {}) {
  options.T_base_laser = recording.T_base_laser;
  if (saved.empty()) {
    BasicSubmapSlam<M> slam(matcher, options);
    return detail::run(slam, recording, progress);
  }
  auto slam = BasicSubmapSlam<M>::restore(saved, matcher, options);
  return slam ? detail::run(*slam, recording, progress) : slam.error();
}

}  // namespace wayfare
