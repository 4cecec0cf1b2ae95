#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <vector>

#include <wayfare/core/detail/call_guard.hpp>
#include <wayfare/slam/detail/graph_slam/field_matching.hpp>
#include <wayfare/slam/detail/graph_slam/node_map.hpp>
#include <wayfare/slam/detail/graph_slam/piece_joiner.hpp>
#include <wayfare/slam/radar_slam.hpp>

#include "slam/radar_slam/scan_filter.hpp"

namespace wayfare {

/// One filter for each part of the map. Where odometry leaps or LiDAR scans match no longer, a
/// filter of a new part begins, beside the map. Parts are joined as those of graph SLAM; the scans
/// of the later part are then given to the earlier one's filter, so that its map is made of both.
class RadarSlam::Engine {
 public:
  Engine(const detail::MakeParticleMatcher& make, const RadarSlamOptions& options);

  Result<void> move(const BiasedMotion& increment) {
    return guard_.run([&] { return add_motion(increment); });
  }
  Result<RbpfOutcome> add_lidar(const LaserScan& scan) {
    return guard_.run([&] { return process(scan); });
  }
  Result<RbpfOutcome> add_radar(LogTime time, const PointSet& points) {
    return guard_.run([&] { return process(time, points); });
  }
  /// Searches for joins from all parts.
  void join_all() {
    (void)guard_.run([&]() -> Result<void> {
      search_all_joins();
      return {};
    });
  }

  [[nodiscard]] const ScanFilter& filter() const { return parts_.at(current_).filter; }
  [[nodiscard]] Trajectory trajectory() const;
  [[nodiscard]] RbpfMaps maps() const;
  [[nodiscard]] WallCrossings wall_crossings() const;
  [[nodiscard]] const RbpfStatistics& statistics() const { return statistics_; }

 private:
  /// A scan as it was given to a filter, after a motion since the one before.
  struct Input {
    LogTime time;
    Sensor sensor;
    PointSet points;
    std::optional<LaserScan> scan;  // of a LiDAR
    BiasedMotion motion{};
  };
  struct Part {
    ScanFilter filter;
    std::vector<Input> inputs;  // of all but the first part
  };
  /// Where the pose of a node is that of a scan.
  struct NodeScan {
    int part = 0;
    std::size_t scan = 0;
  };

  [[nodiscard]] Result<void> in_time(LogTime time, Sensor sensor) const;
  Result<void> add_motion(const BiasedMotion& increment);
  Result<RbpfOutcome> process(const LaserScan& scan);
  Result<RbpfOutcome> process(LogTime time, const PointSet& points);
  Result<RbpfOutcome> process(const Input& input);
  void search_all_joins();
  [[nodiscard]] bool is_lost(LogTime time);
  void begin_part();
  [[nodiscard]] Part& current() { return parts_.at(current_); }
  void add_node(const Input& input);
  void place_nodes();
  bool join(const std::vector<PoseEdge<SE2d>>& edges);
  void append(int part, int later, const SE2d& T_part_later);
  void count();
  [[nodiscard]] bool is_small(int part) const;

  detail::CallGuard guard_;
  detail::MakeParticleMatcher make_;
  RadarSlamOptions options_;
  std::map<int, Part> parts_;                   // by their number in `nodes_`
  int current_ = 0;                             // part
  std::array<std::optional<LogTime>, 2> last_;  // time of the latest scan of each sensor
  std::optional<LogTime> last_scan_;
  BiasedMotion moved_{};          // since that
  std::optional<Motion> before_;  // the same at the scan before
  double before_s_ = 0.0;
  int unmatched_ = 0;  // updates by the LiDAR in a row
  bool begins_piece_ = true;

  detail::NodeMap nodes_;        // of LiDAR scans
  std::vector<NodeScan> scans_;  // of the nodes
  detail::PieceJoiner<detail::FieldMatching> joiner_;
  RbpfStatistics statistics_;
};

}  // namespace wayfare
