#pragma once

// Submap SLAM as a node, without the part that speaks with ROS: messages in, messages out.
//
// Scans are worked on in order, each once odometry has reached its time and the transform to its
// laser is known, so that what comes out does not depend on which of them arrived first.

#include <cstddef>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <wayfare/map/occupancy_grid.hpp>
#include <wayfare/ros/convert.hpp>
#include <wayfare/ros/frame_tree.hpp>
#include <wayfare/ros/messages.hpp>
#include <wayfare/ros/node_output.hpp>
#include <wayfare/system/submap_slam.hpp>

namespace wayfare::ros {

struct SlamNodeOptions {
  SubmapSlamOptions slam{};
  OccupancyGridOptions map{};
  std::string map_frame = "map", odom_frame = "odom", base_frame = "base_link";
  /// False: there is none; the node gives `odom` -> `base_link` itself, by matching scans and,
  /// where `imu`, the gyroscope.
  bool odometry = true;
  bool imu = false;  ///< without odometry: turns come from the inertial unit, its z axis upward
  /// Where the laser is; nothing: by transforms.
  std::optional<Transform2<frame::Base, frame::Laser>> T_base_laser{};

  // Seconds by the caller's clock.
  double patience_s = 2.0;    ///< a scan waits so long for the odometry of its time
  double map_period_s = 5.0;  ///< between maps, while new scans come
  double settle_s = 2.0;      ///< so long without a scan, the graph is optimised to the end

  // Seconds by the messages' clock.
  double jump_back_s = 1.0;     ///< scans this much earlier than the last begin a new map
  double post_date_s = 0.1;     ///< transforms are stamped so much later, to serve till the next
  double odometry_gap_s = 0.5;  ///< odometry older than this says nothing of a scan
  /// Odometry faster than this was set anew, not driven, m/s.
  double max_speed_mps = 10.0;
  std::size_t scans_waiting = 2000;  ///< at most; the oldest are left out
};

/// What is to be published.
struct SlamNodeOutput {
  std::vector<TransformStamped> transforms;  ///< on /tf
  std::vector<PoseStamped> poses;            ///< of the robot in the map
  std::optional<Path> path;
  std::optional<OccupancyGrid> map;
  std::vector<Notice> notices;
};

/// `now_s` is of a clock that never goes back, of any beginning. Not thread-safe.
class SlamNode {
 public:
  explicit SlamNode(SlamNodeOptions options = {});

  void add(const LaserScan& message, double now_s);
  void add(const Odometry& message, double now_s);
  void add(const Imu& message, double now_s);
  void add(const TfMessage& message);

  /// Works on one scan, where one can be. To be called after every message, and a few times a
  /// second without.
  [[nodiscard]] SlamNodeOutput work(double now_s);
  /// Whether `work` has more to do at once.
  [[nodiscard]] bool busy() const { return worked_ && !scans_.empty(); }
  /// The same as if no scan had come for long.
  [[nodiscard]] SlamNodeOutput settle(double now_s);

  [[nodiscard]] const SubmapSlam& slam() const { return *slam_; }
  /// What keeps it from working; empty: nothing does.
  [[nodiscard]] const std::string& waits_for() const { return waits_for_; }

 private:
  struct Waiting {
    wayfare::LaserScan scan;
    std::string frame;
  };

  void begin_anew(LogTime at);
  [[nodiscard]] bool laser_is_known(const std::string& frame, double now_s);
  [[nodiscard]] bool motion_is_known(LogTime time, double now_s);
  [[nodiscard]] MotionHint hint(LogTime time) const;
  void place(Waiting next, double now_s, SlamNodeOutput& out);
  void give_pose(LogTime time, const SE2d& T_map_base, const MotionHint& hint,
                 SlamNodeOutput& out) const;
  void give_map(double now_s, SlamNodeOutput& out);
  void wait_for(std::string what, double now_s);

  SlamNodeOptions options_;
  std::unique_ptr<SubmapSlam> slam_;
  FrameTree frames_;
  std::optional<LevelMounting> laser_;
  std::string laser_frame_;  ///< of the scans taken; empty before the first
  std::deque<Waiting> scans_;
  std::vector<OdometrySample> odometry_;  ///< continuous: joined where it was set anew
  std::optional<SE2d> T_joined_odom_;     ///< from odometry as told to the joined one
  std::vector<GyroSample> gyro_;
  std::optional<LogTime> last_scan_, last_heard_;  ///< placed, received
  std::optional<double> blocked_s_, last_placed_s_;
  double last_map_s_ = 0.0;
  bool worked_ = false, motion_silent_ = false, settled_ = true;
  std::string waits_for_;
  Notices notices_;
};

}  // namespace wayfare::ros
