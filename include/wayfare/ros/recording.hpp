#pragma once

// Recordings of ROS messages, read without ROS: MCAP files (of ROS 2, or ROS 1's messages in them)
// and ROS 1 bags.

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/core/so3.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/ros/serialise.hpp>
#include <wayfare/sensors/gnss.hpp>
#include <wayfare/sensors/imu.hpp>
#include <wayfare/sensors/marg.hpp>
#include <wayfare/sensors/recording.hpp>

namespace wayfare::ros {

struct Topic {
  std::string name;
  std::string type;  ///< as ROS 1 calls it: sensor_msgs/Imu
  Dialect dialect = Dialect::ros1;
};

/// A message as it stands in the file; gone when the callable returns.
struct RecordedMessage {
  const Topic& topic;
  LogTime received;
  std::string_view data;
};

/// A file opened for reading.
class RecordingFile {
 public:
  /// Whether the file is one: a bag by its name (`.bag`, `.bag.gz`), an MCAP file (`.mcap`) by
  /// holding a topic of ROS messages.
  [[nodiscard]] static bool is_one(const std::string& path);
  /// Errors: cannot be read, or is neither.
  [[nodiscard]] static Result<RecordingFile> open(const std::string& path);

  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] const std::vector<Topic>& topics() const { return topics_; }
  [[nodiscard]] const io::Problems& problems() const { return problems_; }

  /// The messages of `topics` as they stand in the file, until `sink` returns false.
  io::Problems read(const std::set<std::string>& topics,
                    const std::function<bool(const RecordedMessage&)>& sink) const;

 private:
  struct Reader;
  std::string path_;
  std::vector<Topic> topics_;
  io::Problems problems_;
  std::shared_ptr<const Reader> reader_;
};

/// Whose clock a measurement's time is: the sender's stamp, or when the recorder received it.
enum class StampSource { header, received };

/// Empty topics are found by their type, where one topic alone has it.
struct TopicNames {
  std::string scan;      ///< sensor_msgs/LaserScan
  std::string odometry;  ///< nav_msgs/Odometry
  std::string radar;     ///< wayfare_msgs/RadarScan, or sensor_msgs/PointCloud2
  /// Where the robot really was: geometry_msgs/PoseStamped or nav_msgs/Odometry; empty: `/truth`.
  std::string truth;
  std::string imu;           ///< sensor_msgs/Imu
  std::string magnetometer;  ///< sensor_msgs/MagneticField
  std::string fix;           ///< sensor_msgs/NavSatFix
  std::string base_frame;    ///< the robot's; empty: the odometry's child, else base_link
  StampSource stamps = StampSource::header;
  /// Streams whose stamps differ by more than this, taken against the times of receipt, are on
  /// different clocks.
  Duration clock_tolerance = from_seconds(1.0);
};

/// A robot's run: scans, odometry and radar frames, turn rates of an inertial unit about the
/// robot's z axis, true poses, and how laser and radar are mounted, as the transforms say. Without
/// a topic of odometry, the transforms from `odom` are taken for it.
struct RobotRun {
  Recording recording;
  /// Empty: there is none.
  std::string scan_topic, odometry_topic, radar_topic, imu_topic, truth_topic;
  io::Problems problems;
};
/// Errors: neither scans nor radar; a topic that is named but not there, or one of several and not
/// named; no message of a topic that can be used (the first one's fault is said); streams on
/// different clocks; a laser that is not level. A unit or truths that were not named are left out
/// instead, which `problems` say.
[[nodiscard]] Result<RobotRun> read_robot(const RecordingFile& file, const TopicNames& names = {});

struct MargRun {
  MargRecording samples;  ///< in order of time; a magnetometer's own readings stand by themselves
  std::string topic;
  /// Rotates the unit's axes to the robot's; nothing where no transform says.
  std::optional<SO3d> q_base_unit{};
  io::Problems problems;
};
/// An inertial unit, with a magnetometer where there is one. Errors as above.
[[nodiscard]] Result<MargRun> read_marg(const RecordingFile& file, const TopicNames& names = {});

struct VehicleRun {
  std::vector<ImuSample> imu;
  std::vector<GnssFix> fixes;
  io::Problems problems;
};
/// An inertial unit and a satellite receiver's fixes. Errors as above.
[[nodiscard]] Result<VehicleRun> read_vehicle(const RecordingFile& file,
                                              const TopicNames& names = {});

}  // namespace wayfare::ros
