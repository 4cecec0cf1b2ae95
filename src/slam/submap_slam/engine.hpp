#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <wayfare/core/detail/call_guard.hpp>
#include <wayfare/slam/detail/loops.hpp>
#include <wayfare/slam/detail/motion.hpp>
#include <wayfare/slam/submap_slam.hpp>

#include "slam/submap_slam/local_tracker.hpp"
#include "slam/submap_slam/loop_search.hpp"
#include "slam/submap_slam/pieces.hpp"
#include "slam/submap_slam/pose_uncertainty.hpp"
#include "slam/submap_slam/submap_graph.hpp"

namespace wayfare {

class SubmapSlamSystem::Engine {
 public:
  Engine(const SubmapSlamOptions& options, detail::SubmapMaps maps);

  Result<ScanOutcome> add_scan(const LaserScan& scan, const MotionHint& hint) {
    return guard_.run([&] { return add(scan, hint); });
  }
  Result<void> finish() {
    return guard_.run([&] { return finish_all(); });
  }
  [[nodiscard]] Trajectory trajectory() const;
  [[nodiscard]] const PoseGraph2& graph() const { return map_.graph; }
  [[nodiscard]] const SubmapSlamStatistics& statistics() const { return statistics_; }
  [[nodiscard]] const LocalPlacement& local() const { return local_; }
  [[nodiscard]] Eigen::Matrix3d covariance();
  [[nodiscard]] OccupancyGrid map(const OccupancyGridOptions& shape,
                                  const InverseLidarModel& model) const;
  [[nodiscard]] OccupancyGrid latest_part(const OccupancyGridOptions& shape,
                                          const InverseLidarModel& model) const;
  [[nodiscard]] Trajectory latest_trajectory() const;
  [[nodiscard]] WallCrossings wall_crossings(const OccupancyGrid& map) const;
  [[nodiscard]] std::size_t memory_bytes();
  void drop_tables() {
    (void)search_.result();
    search_.drop_tables();
  }
  [[nodiscard]] std::vector<std::uint8_t> save();
  Result<void> restore(std::span<const std::uint8_t> bytes);

 private:
  Result<ScanOutcome> add(const LaserScan& scan, const MotionHint& hint);
  Result<void> finish_all();

  /// A scan with its motion.
  struct Placed {
    SE2d T_local_base;
    double score = 0.0;
    bool matched = false;
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    double openness = 1.0;
    Eigen::Vector3d predicted_sigma = Eigen::Vector3d::Zero();
  };

  [[nodiscard]] Result<PointSet> points_of(const LaserScan& scan) const;
  [[nodiscard]] Motion predict(LogTime time, const std::optional<SE2d>& odometry,
                               const std::optional<Angle>& turn) const;
  [[nodiscard]] Result<Placed> place(const PointSet& points, const Motion& motion,
                                     const std::optional<Motion>& by_velocity,
                                     MatcherErrors& errors) const;
  /// What a scan says on whether tracking is lost.
  struct Tracking {
    bool lost = false;
    bool sure = true;  ///< false: its match may be wrong
  };
  [[nodiscard]] bool leaps(const Motion& motion, const std::optional<Motion>& by_velocity,
                           const MotionHint& hint, LogTime time) const;
  [[nodiscard]] Tracking judge(const Placed& placed, const Motion& motion, bool leaped,
                               std::size_t points, LogTime time);
  Result<void> begin_piece(const PointSet& points, const Motion& motion, bool leaped);
  void join_pieces();
  template <class Includes>
  [[nodiscard]] OccupancyGrid map_of(const OccupancyGridOptions& shape,
                                     const InverseLidarModel& model,
                                     const Includes& includes) const;
  void move(const Motion& motion, const Placed& placed);
  [[nodiscard]] bool is_due(bool matched) const;
  Result<void> add_node(const PointSet& points, const Placed& placed);
  void join_node(const std::shared_ptr<const PackedPoints>& points, const Placed& placed);
  Result<void> node_added(bool lost);
  Result<void> end_submaps(bool lost);
  void join_loops(ScanOutcome& outcome);
  void begin_search();
  void forget();
  Result<void> optimise(int iterations, double min_gain);

  friend struct SubmapState;

  SubmapSlamOptions options_;
  detail::CallGuard guard_;
  std::string matcher_;  // its name
  MotionModel motion_model_;
  LocalTracker tracker_;
  LoopSearch search_;
  SubmapPieces pieces_;
  PoseGraphOptimiser<SE2d> optimiser_;
  PoseUncertainty uncertainty_;

  SubmapGraph map_;
  LocalPlacement local_;
  SE2d T_local_base_;                                     // of the latest scan
  Eigen::Matrix3d since_node_ = Eigen::Matrix3d::Zero();  // covariance of the motion since then
  Eigen::Matrix3d since_match_ = Eigen::Matrix3d::Zero();
  // Of the latest match and the motion since; since the node, where no match has placed it.
  Eigen::Matrix3d placed_ = Eigen::Matrix3d::Zero();
  int lost_ = 0;  // consecutive scans without agreement
  int nodes_since_search_ = 0;
  std::optional<std::uint64_t> join_at_;  // number of scans at which the running search is joined
  Trajectory forgotten_;                  // of scans whose nodes were dropped
  std::vector<ScanPose> scans_;
  SubmapSlamStatistics statistics_;
};

}  // namespace wayfare
