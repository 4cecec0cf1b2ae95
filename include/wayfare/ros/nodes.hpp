#pragma once

// Pedestrian dead reckoning as a node, without the interface to ROS.
//
// SLAM as a node, without the interface to ROS: messages in, messages out. Laser scans alone use
// submap SLAM, Hector SLAM or pedestrian SLAM; radar, alone or with laser scans, uses the particle
// filter.
//
// Scans are processed in order, each once odometry and inertial samples have reached its time and
// the transform to its laser is known, so that the result does not depend on the order of arrival:
// it is that of the system on a recording of the messages.

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/detail/owned.hpp>
#include <wayfare/core/gaussian.hpp>
#include <wayfare/map/occupancy_grid.hpp>
#include <wayfare/pedestrian/pedestrian.hpp>
#include <wayfare/ros/convert.hpp>
#include <wayfare/ros/detail/node_output.hpp>
#include <wayfare/ros/messages.hpp>
#include <wayfare/ros/scan_node.hpp>
#include <wayfare/slam/hector_slam.hpp>
#include <wayfare/slam/pedestrian_slam.hpp>
#include <wayfare/slam/radar_slam.hpp>
#include <wayfare/slam/submap_slam.hpp>
#include <wayfare/sync/scan_deskewer.hpp>

namespace wayfare::ros {

/// Dead reckoning and frames of a PedestrianNode.
struct PedestrianNodeOptions {
  PedestrianParameters pedestrian{};  ///< detection, lengths and attitude
  std::string odom_frame = "odom",    ///< of the odometry
      base_frame = "base_link";       ///< of the unit's carrier
  double jump_back_s = 1.0;  ///< samples this much earlier than the last restart the reckoning
  /// Interval between poses at rest …
  double rest_period_s = 0.1;
  /// … which end this long before the time until which steps are known: the body moves before the
  /// crest that is a step's time.
  double rest_margin_s = 0.3;
};

/// Messages to publish.
struct PedestrianNodeOutput {
  /// One per step, with covariance; at rest the pose of the last step again, at later times and
  /// without speed.
  std::vector<Odometry> odometry;
  std::vector<Notice> notices;  ///< for the log
};

/// `now_s` is of a monotonic clock. Not thread-safe.
class PedestrianNode {
 public:
  /// Without samples.
  explicit PedestrianNode(PedestrianNodeOptions options = {});

  /// Rates and forces of the unit.
  [[nodiscard]] PedestrianNodeOutput add(const Imu& message, double now_s);
  /// Its field.
  [[nodiscard]] PedestrianNodeOutput add(const MagneticField& message, double now_s);
  /// Call it a few times per second: reports missing input.
  [[nodiscard]] PedestrianNodeOutput idle(double now_s);

 private:
  void take(const MargSample& sample, double now_s, PedestrianNodeOutput& out);
  void rest(PedestrianNodeOutput& out);

  PedestrianNodeOptions options_;
  Pedestrian pedestrian_;
  std::optional<LogTime> last_, last_pose_;
  std::optional<double> heard_s_;
  std::optional<PedestrianPose> before_;
  Notices notices_;
};

/// One step's pose as odometry; the speed is that since `before`.
[[nodiscard]] Odometry odometry_message(const PedestrianPose& pose,
                                        const std::optional<PedestrianPose>& before,
                                        const std::string& odom_frame,
                                        const std::string& base_frame);

/// SLAM of laser scans alone.
enum class LaserSystem : std::uint8_t {
  submap,      ///< submaps and a pose graph
  hector,      ///< one map, to which all scans are matched
  pedestrian,  ///< submaps, with scans levelled and steps by a unit on the head
};

/// SLAM, frames, mounting and waiting of a SlamNode.
struct SlamNodeOptions : ScanNodeOptions {
  SlamSensors sensors = SlamSensors::lidar;  ///< the scans used
  LaserSystem system = LaserSystem::submap;  ///< for laser scans alone
  SubmapSlamOptions slam{};                  ///< of submap and pedestrian SLAM
  HectorSlamOptions hector{};                ///< of Hector SLAM
  PedestrianSlamOptions walker{};            ///< of pedestrian SLAM, without its `slam`
  OccupancyGridOptions map{};                ///< as `slam`; the others have their own cells
  RadarSlamOptions filter{};                 ///< with radar
  /// False, for laser scans alone: without odometry; the node publishes `odom` -> `base_link` from
  /// scan matching and, with `imu`, the inertial unit. Pedestrian SLAM takes none.
  bool odometry = true;
  /// With laser scans alone, waits for inertial samples: submap SLAM without odometry takes heading
  /// changes from them, the unit's z axis upward; Hector SLAM levels scans and fuses its matches
  /// with them; pedestrian SLAM needs them and always takes them.
  bool imu = false;
  bool magnetometer = false;  ///< waits for its readings, too: for pedestrian SLAM
  /// Mounting of the radar; if empty, from transforms.
  std::optional<Transform2<frame::Base, frame::Radar>> T_base_radar{};
  /// Of Hector and pedestrian SLAM: the unit's axis along which the laser's x points, its z upward.
  std::optional<Eigen::Vector3d> unit_forward{};

  // Seconds by the caller's clock.
  double map_period_s = 5.0;  ///< between maps, while scans arrive
  double settle_s = 2.0;  ///< time without scans after which the graph is optimised to convergence

  /// Odometry faster than this has been reset, m/s.
  double max_speed_mps = 10.0;
};

/// Messages to publish.
struct SlamNodeOutput {
  std::vector<TransformStamped> transforms;  ///< on /tf
  /// Of the robot in the map, with the covariance of the system, relative to the first pose of the
  /// map.
  std::vector<PoseWithCovarianceStamped> poses;
  /// Of the particle filter, every `particle_period_s`: their latest poses, without their weights.
  std::optional<PoseArray> particles;
  /// All poses, with each map. Where tracking was lost, path and map are of the part of the map
  /// where the robot is, until it is joined to the others; the notices say so.
  std::optional<Path> path;
  std::optional<OccupancyGrid> map;  ///< every `map_period_s`
  std::vector<Notice> notices;       ///< for the log
};

class LaserSlam;

/// `now_s` is of a monotonic clock with any origin. Not thread-safe.
class SlamNode : public ScanNode {
 public:
  /// Without scans.
  explicit SlamNode(SlamNodeOptions options = {});

  /// A scan of a laser, queued until its odometry is there.
  void add(const LaserScan& message, double now_s);
  /// Of a radar's two message types the first received is used.
  void add(const RadarScan& message, double now_s);
  /// A frame of a radar, as the first received type of message.
  void add(const PointCloud2& message, double now_s);
  /// Ignored where SlamNodeOptions::odometry is false.
  void add(const Odometry& message, double now_s);
  /// Used with SlamNodeOptions::imu.
  void add(const Imu& message, double now_s);
  /// Of the unit, with `magnetometer`.
  void add(const MagneticField& message, double now_s);
  /// Mountings, from /tf and /tf_static.
  void add(const TfMessage& message);

  /// Processes one scan, if possible. Call it after every message, and a few times per second
  /// without.
  [[nodiscard]] SlamNodeOutput work(double now_s);
  /// Whether `work` can process more at once.
  [[nodiscard]] bool busy() const { return worked_ && (stream_ || !lasers_.scans.empty()); }
  /// As after a long time without scans.
  [[nodiscard]] SlamNodeOutput finish(double now_s);

 private:
  enum class RadarMessage : std::uint8_t { none, scan, cloud };

  template <class Message>
  void add_radar(const Message& message, RadarMessage kind, double now_s);
  [[nodiscard]] Restart restart();
  void restart_at(LogTime at);

  [[nodiscard]] bool takes_turns() const { return options_.system == LaserSystem::submap; }
  [[nodiscard]] Result<void> add_turn_rate(const Imu& message, LogTime time);
  [[nodiscard]] Result<void> add_sample(const Imu& message, LogTime time);
  [[nodiscard]] bool is_next(LogTime time);
  MargSample& sample_at(LogTime time);
  void pass_samples(LogTime until);

  [[nodiscard]] bool laser_is_mounted(double now_s);
  [[nodiscard]] bool unit_is_mounted(double now_s);
  [[nodiscard]] bool has_system(double now_s);
  [[nodiscard]] bool motion_is_known(LogTime time, double now_s);
  [[nodiscard]] MotionHint hint(LogTime time) const;
  [[nodiscard]] bool leaped(LogTime time) const;
  [[nodiscard]] Result<ScanOutcome> add_deskewed(const wayfare::LaserScan& scan);
  void process_scan(double now_s, SlamNodeOutput& out);
  void placed(LogTime time, const Gaussian<SE2d>& T_map_base, double now_s, SlamNodeOutput& out);

  // With radar.
  [[nodiscard]] bool has_stream(double now_s);
  void pass_to_stream();
  void process_stream(double now_s, SlamNodeOutput& out);
  bool step(double now_s, SlamNodeOutput& out);

  void publish_pose(LogTime time, const Gaussian<SE2d>& T_map_base, const MotionHint& hint,
                    SlamNodeOutput& out) const;
  void publish_particles(LogTime time, SlamNodeOutput& out);
  void publish_map(double now_s, SlamNodeOutput& out);
  void say_pieces(double now_s);

  SlamNodeOptions options_;
  detail::Owned<LaserSlam> slam_;  ///< once the mounting of its sensors is known
  std::optional<ScanDeskewer> deskewer_;
  std::optional<RadarSlamStream> stream_;
  Sensed<wayfare::LaserScan> lasers_;
  Sensed<wayfare::RadarScan> radar_;
  RadarMessage radar_message_ = RadarMessage::none;
  /// From odometry as received to the samples kept, which are joined at resets.
  std::optional<SE2d> T_joined_odom_;
  /// Between two samples odometry was set, or the robot carried.
  struct Leap {
    LogTime from, to;
  };
  std::vector<Leap> leaps_;
  PieceStatistics said_;                    ///< in notices
  std::optional<LogTime> odometry_passed_;  ///< passed to the stream
  std::vector<GyroSample> gyro_;
  std::deque<MargSample> unit_;  ///< not passed to the system yet, in order of time
  std::string unit_frame_;       ///< of the first sample; others are dropped
  std::optional<SO3d> q_base_unit_;
  Awaited unit_heard_{"inertial samples"}, field_heard_{"a magnetic field"};
  std::optional<LogTime> last_scan_;  ///< processed
  std::optional<double> last_placed_s_;
  double last_map_s_ = 0.0;
  bool worked_ = false, settled_ = true;
};

}  // namespace wayfare::ros
