#pragma once

// Monte-Carlo localisation on a known map as a node, without the interface to ROS: messages in,
// messages out, with the interface of ROS's AMCL.
//
// Scans are processed as by run_localisation on a recording of the messages: in order, each once
// odometry has reached its time. A given pose applies at its stamp, and moves by odometry from
// there.

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <wayfare/core/gaussian.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/ros/detail/node_output.hpp>
#include <wayfare/ros/messages.hpp>
#include <wayfare/ros/scan_node.hpp>
#include <wayfare/slam/localisation.hpp>
#include <wayfare/sync/scan_deskewer.hpp>

namespace wayfare::ros {

/// Where a LocaliseNode gets its odometry from.
enum class OdometrySource : std::uint8_t {
  messages,    ///< nav_msgs/Odometry
  transforms,  ///< `odom` -> `base_link` on /tf, also by way of frames fixed to the base
};

/// Localisation, frames, mounting and waiting of a LocaliseNode.
struct LocaliseNodeOptions : ScanNodeOptions {
  LocalisationOptions localisation{};  ///< without its mounting; scans of a LiDAR only
  LocalisationMapOptions map{};        ///< how messages become maps
  std::uint64_t seed = 1;              ///< of the particles
  OdometrySource source = OdometrySource::messages;  ///< of the odometry
  /// Pose of the robot in the map at the first scan; without it the node waits for one …
  std::optional<Gaussian<SE2d>> initial{};
  bool global = false;  ///< … or searches the whole map
};

/// Messages to publish.
struct LocaliseNodeOutput {
  std::vector<TransformStamped> transforms;      ///< map to odometry, on /tf
  std::vector<PoseWithCovarianceStamped> poses;  ///< of the robot in the map, while localised
  std::optional<ParticleCloud> particles;        ///< every `particle_period_s`
  std::vector<Notice> notices;                   ///< for the log
};

/// `now_s` is of a monotonic clock with any origin. Not thread-safe.
class LocaliseNode : public ScanNode {
 public:
  /// Without a map.
  explicit LocaliseNode(LocaliseNodeOptions options = {});

  /// The map, in the map's frame. One that is equal to the last is ignored; another one replaces
  /// it: the robot keeps its pose where it is localised. An invalid one is left out.
  void add(const OccupancyGrid& message, double now_s);
  /// A scan of a laser, queued until its odometry is there.
  void add(const LaserScan& message, double now_s);
  /// Ignored where odometry is by transforms.
  void add(const Odometry& message, double now_s);
  /// Mounting, and odometry where it is by transforms, from /tf and /tf_static.
  void add(const TfMessage& message, double now_s);
  /// The robot's pose in the map at the message's stamp, or at the next scan where that is zero.
  void add(const PoseWithCovarianceStamped& message, double now_s);
  /// Forgets the pose and searches the whole map.
  void search_everywhere() { located_ = false, given_.reset(), global_ = true; }

  /// Processes one scan, if possible. Call it after every message, and a few times per second
  /// without.
  [[nodiscard]] LocaliseNodeOutput work(double now_s);
  /// Whether `work` can process more at once.
  [[nodiscard]] bool busy() const { return worked_ && !laser_.scans.empty(); }

  /// Of the last scan processed, in the map.
  [[nodiscard]] const std::optional<LocalisationOutcome>& outcome() const { return outcome_; }

 private:
  /// A pose of the robot in the map, and its time if it has one.
  struct GivenPose {
    Gaussian<SE2d> T_map_base;
    std::optional<LogTime> at{};
  };

  void restart();
  void restart_at(LogTime at);
  [[nodiscard]] bool has_pose(double now_s);
  [[nodiscard]] bool applies(const GivenPose& given, LogTime scan) const;
  [[nodiscard]] Gaussian<SE2d> pose_for(const GivenPose& given, LogTime scan, double now_s);
  void start_by(LogTime scan, double now_s);
  void process_scan(double now_s, LocaliseNodeOutput& out);
  [[nodiscard]] Result<LocalisationOutcome> add_scan(const wayfare::LaserScan& scan, double now_s);
  void publish(double now_s, LocaliseNodeOutput& out);
  void report(const LocalisationOutcome& now, double now_s);

  LocaliseNodeOptions options_;
  std::optional<OccupancyGrid> map_message_;
  std::shared_ptr<const LocalisationMap> map_;
  SE2d T_map_grid_;  ///< of the map's lower left corner, in whose frame the localiser works
  std::optional<Localiser> localiser_;  ///< once the mounting of the laser is known
  std::optional<ScanDeskewer> deskewer_;
  Sensed<wayfare::LaserScan> laser_;
  std::optional<GivenPose> given_;  ///< not applied yet
  bool global_ = false;             ///< the whole map is to be searched
  bool located_ = false;            ///< the localiser has begun
  std::optional<LogTime> last_;     ///< of the scans processed
  std::optional<LocalisationOutcome> outcome_;
  bool worked_ = false;
};

/// The particles as a message, in a frame.
[[nodiscard]] ParticleCloud particle_cloud(std::span<const PoseParticle> particles, LogTime time,
                                           std::string_view frame);

}  // namespace wayfare::ros
