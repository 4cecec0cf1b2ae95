#pragma once

// SLAM as a node, without the part that speaks with ROS: messages in, messages out. Laser scans
// alone go to submap SLAM, radar and both to the particle filter.
//
// Scans are worked on in order, each once odometry has reached its time and the transform to its
// laser is known, so that what comes out does not depend on which of them arrived first.

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <wayfare/map/occupancy_grid.hpp>
#include <wayfare/ros/convert.hpp>
#include <wayfare/ros/detail/node_output.hpp>
#include <wayfare/ros/frame_tree.hpp>
#include <wayfare/ros/messages.hpp>
#include <wayfare/slam/radar_slam_stream.hpp>
#include <wayfare/slam/submap_slam.hpp>

namespace wayfare::ros {

struct SlamNodeOptions {
  SlamSensors sensors = SlamSensors::lidar;
  SubmapSlamOptions slam{};    ///< of laser scans alone
  OccupancyGridOptions map{};  ///< the same; the filter gives its own cells
  RadarSlamOptions filter{};   ///< with radar
  std::string map_frame = "map", odom_frame = "odom", base_frame = "base_link";
  /// False, for laser scans alone: there is none; the node gives `odom` -> `base_link` itself, by
  /// matching scans and, where `imu`, the gyroscope.
  bool odometry = true;
  bool imu = false;  ///< without odometry: turns come from the inertial unit, its z axis upward
  /// Where the sensors are; nothing: by transforms.
  std::optional<Transform2<frame::Base, frame::Laser>> T_base_laser{};
  std::optional<Transform2<frame::Base, frame::Radar>> T_base_radar{};

  // Seconds by the caller's clock.
  double patience_s = 2.0;    ///< a scan waits so long for what else is of its time
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
  /// Of a radar's two kinds of messages the one that comes first is listened to.
  void add(const RadarScan& message, double now_s);
  void add(const PointCloud2& message, double now_s);
  void add(const Odometry& message, double now_s);
  void add(const Imu& message, double now_s);
  void add(const TfMessage& message);

  /// Works on one scan, where one can be. To be called after every message, and a few times a
  /// second without.
  [[nodiscard]] SlamNodeOutput work(double now_s);
  /// Whether `work` has more to do at once.
  [[nodiscard]] bool busy() const { return worked_ && (stream_ || !lasers_.scans.empty()); }
  /// The same as if no scan had come for long.
  [[nodiscard]] SlamNodeOutput settle(double now_s);

  /// What keeps it from working; empty: nothing does.
  [[nodiscard]] const std::string& waits_for() const { return waits_for_; }

 private:
  template <class Scan>
  struct Sensed {
    std::deque<Scan> scans;  ///< not worked on yet
    std::optional<LogTime> last_heard;
    std::string frame;  ///< of the first; no other's are taken
    std::optional<LevelMounting> mounting;
  };
  enum class RadarMessage : std::uint8_t { none, scan, cloud };

  template <class Message>
  void add_radar(const Message& message, RadarMessage kind, double now_s);
  template <class Scan>
  void enqueue(Sensed<Scan>& to, Result<Scan> scan, const Header& header, double now_s);
  void begin_anew(LogTime at);

  template <class Scan, class Given>
  [[nodiscard]] bool is_mounted(Sensed<Scan>& sensed, const Given& T_base_sensor, double now_s);
  [[nodiscard]] bool laser_is_known(double now_s);
  [[nodiscard]] bool motion_is_known(LogTime time, double now_s);
  [[nodiscard]] MotionHint hint(LogTime time) const;
  void work_on_scan(double now_s, SlamNodeOutput& out);
  void placed(LogTime time, const SE2d& T_map_base, double now_s, SlamNodeOutput& out);

  // With radar.
  [[nodiscard]] bool stream_is_there(double now_s);
  void hand_over();
  void work_on_stream(double now_s, SlamNodeOutput& out);
  bool step(double now_s, SlamNodeOutput& out);

  void give_pose(LogTime time, const SE2d& T_map_base, const MotionHint& hint,
                 SlamNodeOutput& out) const;
  void give_map(double now_s, SlamNodeOutput& out);
  void wait_for(std::string what, double now_s);

  SlamNodeOptions options_;
  std::unique_ptr<SubmapSlam> slam_;
  std::optional<RadarSlamStream> stream_;
  FrameTree frames_;
  Sensed<wayfare::LaserScan> lasers_;
  Sensed<wayfare::RadarScan> radar_;
  RadarMessage radar_message_ = RadarMessage::none;
  std::vector<OdometrySample> odometry_;   ///< continuous: joined where it was set anew
  std::optional<SE2d> T_joined_odom_;      ///< from odometry as told to the joined one
  std::optional<LogTime> odometry_given_;  ///< to the stream
  std::vector<GyroSample> gyro_;
  std::optional<LogTime> last_scan_;  ///< placed
  std::optional<double> blocked_s_, last_placed_s_;
  double last_map_s_ = 0.0;
  bool worked_ = false, motion_silent_ = false, settled_ = true;
  std::string waits_for_;
  Notices notices_;
};

}  // namespace wayfare::ros
