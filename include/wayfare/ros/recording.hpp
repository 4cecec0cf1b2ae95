#pragma once

// Recordings of ROS messages, readable without ROS: MCAP files (of ROS 2, or with ROS 1 messages)
// and ROS 1 bags.
//
// Writing recordings of ROS messages, without ROS: in the format of ROS 2 (MCAP with CDR) or as a
// ROS 1 bag.

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <wayfare/core/detail/owned.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/io/mcap.hpp>
#include <wayfare/io/nav_text.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/ros/serialise.hpp>
#include <wayfare/sensors/measurements.hpp>
#include <wayfare/sensors/recording.hpp>

namespace wayfare::ros {

/// A topic of a recording.
struct Topic {
  std::string name;                 ///< such as /scan
  std::string type;                 ///< ROS 1 name: sensor_msgs/Imu
  Dialect dialect = Dialect::ros1;  ///< serialisation of its messages
};

/// A message as stored in the file; valid until the callable returns.
struct RecordedMessage {
  const Topic& topic;     ///< its topic
  LogTime received;       ///< time of receipt
  std::string_view data;  ///< serialised message
};

/// A file opened for reading.
class RecordingFile {
 public:
  /// Whether the file is a recording: a bag by its name (`.bag`, `.bag.gz`), an MCAP file (`.mcap`)
  /// by a topic of ROS messages.
  [[nodiscard]] static bool is_one(const std::string& path);
  /// Errors: unreadable, or neither.
  [[nodiscard]] static Result<RecordingFile> open(const std::string& path);

  /// As given to open().
  [[nodiscard]] const std::string& path() const { return path_; }
  /// Of ROS messages, with messages or without.
  [[nodiscard]] const std::vector<Topic>& topics() const { return topics_; }
  /// Faults of the file found when it was opened.
  [[nodiscard]] const io::Problems& problems() const { return problems_; }

  /// The messages of `topics` as stored in the file, until `sink` returns false.
  io::Problems read(const std::set<std::string>& topics,
                    const std::function<bool(const RecordedMessage&)>& sink) const;

 private:
  struct Reader;
  std::string path_;
  std::vector<Topic> topics_;
  io::Problems problems_;
  std::shared_ptr<const Reader> reader_;
};

/// Source of a measurement's time: the sender's stamp, or the time of receipt.
enum class StampSource {
  header,    ///< of the message's header
  received,  ///< of the file
};

/// The wheels of a robot in its sensor_msgs/JointState.
struct WheelJoints {
  std::string topic;  ///< empty: the only one
  /// Of the left and the right wheel; empty: those of `RobotTopics`, if they are there.
  std::vector<std::string> names;
  /// Radius of the wheels; none: by the robot description, URDF as std_msgs/String.
  std::optional<double> radius_m;
  std::optional<double> base_m;  ///< distance between the wheels; none: likewise
  double max_speed_mps = 10.0;   ///< of a wheel; faster is a jump of its position
};

/// An empty topic stands for the only one of its type.
struct TopicNames {
  std::string scan;      ///< sensor_msgs/LaserScan
  std::string odometry;  ///< nav_msgs/Odometry
  std::string radar;     ///< wayfare_msgs/RadarScan, or sensor_msgs/PointCloud2
  /// True poses: geometry_msgs/PoseStamped, geometry_msgs/PoseWithCovarianceStamped or
  /// nav_msgs/Odometry; empty: `/truth`.
  std::string truth;
  /// Two frames, of the world and the robot: true poses by the transforms between them instead, or
  /// if there are only some by way of other frames, by those.
  std::vector<std::string> truth_frames;
  std::string imu;           ///< sensor_msgs/Imu
  std::string magnetometer;  ///< sensor_msgs/MagneticField
  std::string fix;           ///< sensor_msgs/NavSatFix
  WheelJoints wheels = {};   ///< odometry by wheels
  /// Radial speeds of the radar wrap beyond ± this, m/s; none: by the robot description.
  std::optional<double> radar_max_speed_mps = {};
  std::string base_frame;  ///< the robot's; empty: the odometry's child, else base_link
  StampSource stamps = StampSource::header;  ///< whose time measurements get
  /// Streams whose stamps differ by more than this, relative to the times of receipt, are on
  /// different clocks.
  Duration clock_tolerance = from_seconds(1.0);
};

/// A robot's recording: scans, odometry and radar frames, turn rates of an inertial unit about the
/// robot's z axis, wheels, true poses, and the mounting of laser and radar by the transforms.
/// Without a topic of odometry, the transforms from `odom` are used instead.
///
/// A wheel's distance is the change of its joint's position times its radius, the first one zero;
/// in messages without positions, the mean of two velocities times the time between. A jump of
/// position is bridged at the speed before. Wheels that contradict the unit's turn rate in most of
/// the turns are noted in `problems`, but kept.
struct RobotRun {
  Recording recording;  ///< all streams, in order of time
  /// Empty if there is none.
  std::string scan_topic,  ///< of the scans
      odometry_topic,      ///< of the odometry; or empty
      radar_topic,         ///< of the radar
      imu_topic,           ///< of the unit
      truth_topic,         ///< of the truth
      wheel_topic;         ///< of the wheels
  io::Problems problems;   ///< messages that were left out
};
/// Errors: neither scans nor radar; a named topic that is missing, or several of a type with none
/// named; a topic without a usable message (with the first one's error); streams on different
/// clocks; a laser that is not level; wheels that are named, but not there (the joints there are
/// are listed), or of unknown radius; a radius, base or speed that is not a positive number.
/// Wheels, a unit or truth that were not named are dropped instead, with a note in `problems`.
[[nodiscard]] Result<RobotRun> read_robot(const RecordingFile& file, const TopicNames& names = {});

/// True poses alone; none if there is no topic of them and none is named. Errors as above.
struct TruthRun {
  Trajectory truth;       ///< one pose per time
  std::string topic;      ///< of the poses, or empty
  io::Problems problems;  ///< messages that were left out
};
/// True poses of a recording.
[[nodiscard]] Result<TruthRun> read_truth(const RecordingFile& file, const TopicNames& names = {});

/// Samples of an inertial unit and its mounting.
struct MargRun {
  MargRecording samples;  ///< in order of time; a magnetometer's own samples are separate entries
  std::string topic;      ///< of the unit
  /// Rotates the unit's axes to the robot's; nothing without a transform.
  std::optional<SO3d> q_base_unit{};
  io::Problems problems;  ///< messages that were left out
};
/// An inertial unit, with a magnetometer if there is one. Errors as above.
[[nodiscard]] Result<MargRun> read_marg(const RecordingFile& file, const TopicNames& names = {});

/// Measurements of a vehicle.
struct VehicleRun {
  std::vector<ImuSample> imu;  ///< in order of time
  std::vector<GnssFix> fixes;  ///< in order of time
  io::Problems problems;       ///< messages that were left out
};
/// An inertial unit and a satellite receiver's fixes. Errors as above.
[[nodiscard]] Result<VehicleRun> read_vehicle(const RecordingFile& file,
                                              const TopicNames& names = {});

/// Inertial samples, or fixes, of a ROS recording or, if `path` is none, of columns of text.
/// Errors: also a recording without any.
[[nodiscard]] Result<io::ImuFile> read_imu(const std::string& path, const io::ColumnFormat& format,
                                           const TopicNames& names = {});
/// Fixes of a ROS recording, or of columns of text.
[[nodiscard]] Result<io::FixFile> read_fixes(const std::string& path,
                                             const io::ColumnFormat& format,
                                             const TopicNames& names = {});

/// A topic whose messages are recorded as they were received.
struct ReceivedTopic {
  std::string name;                ///< such as /scan
  std::string type;                ///< ROS 1 name: sensor_msgs/Imu
  std::string definition = {};     ///< by definition<M>(Dialect::ros2); empty: not known
  io::McapMetadata metadata = {};  ///< of the MCAP channel
};

/// Writes messages to a file.
class RecordingWriter {
 public:
  /// The format follows the name: `.mcap` or `.bag`. Errors: another suffix; the file exists (see
  /// `options`), or cannot be written.
  [[nodiscard]] static Result<RecordingWriter> create(const std::string& path,
                                                      const io::WriteOptions& options = {});

  /// Errors: a time before 1970, a topic with messages of another type, or of the disk.
  template <Message M>
  [[nodiscard]] Result<void> write(const std::string& topic, LogTime received, const M& message) {
    if (!knows(topic, M::kType))
      if (auto added = add(topic, M::kType, definition<M>(dialect())); !added) return added;
    return write_bytes(topic, received, to_bytes(message, dialect()));
  }

  /// A message serialised as CDR; of a type that is not known the file has no definition, but its
  /// name. Errors: as of `write`; a bag, which is of ROS 1.
  [[nodiscard]] Result<void> write_received(const ReceivedTopic& topic, LogTime received,
                                            std::string_view cdr);

  /// Closes the file; nothing can be written afterwards. A bag is complete on the disk only now; if
  /// that fails, it can be tried again.
  [[nodiscard]] Result<void> close();

 private:
  struct Impl;
  explicit RecordingWriter(detail::Owned<Impl> impl);
  [[nodiscard]] Dialect dialect() const;
  [[nodiscard]] bool knows(const std::string& topic, const MessageType& type) const;
  [[nodiscard]] Result<void> add(const std::string& topic, const MessageType& type,
                                 const std::string& definition,
                                 const io::McapMetadata& metadata = {});
  [[nodiscard]] Result<void> write_bytes(const std::string& topic, LogTime received,
                                         std::string_view data);

  detail::Owned<Impl> impl_;
};

/// An inertial unit recorded with a robot.
struct UnitRun {
  std::span<const MargSample> samples = {};  ///< in order of time
  SE2d T_base_unit = {};                     ///< mounting; the gyro is about its z axis
};

/// Names of topics and frames that write_robot uses.
struct RobotTopics {
  std::string scan = "/scan",                   ///< scans
      odometry = "/odom",                       ///< poses and /tf
      radar = "/radar",                         ///< radar frames
      imu = "/imu";                             ///< gyro or unit
  std::string truth = "/truth",                 ///< true poses
      magnetometer = "/magnetic_field";         ///< field of a unit
  std::string map_frame = "map",                ///< of the truth
      odom_frame = "odom",                      ///< of the odometry
      base_frame = "base_link";                 ///< of the robot
  std::string laser_frame = "laser",            ///< of the scans
      radar_frame = "radar",                    ///< of the radar
      imu_frame = "imu";                        ///< of the unit
  std::string joints = "/joint_states",         ///< of the wheels
      description = "/robot_description";       ///< wheels and radar, URDF
  std::string left_wheel = "left_wheel_joint",  ///< its joint
      right_wheel = "right_wheel_joint";        ///< its joint
  /// Of the joints' wheels: with a power of two, positions in radians are as exact as distances.
  double wheel_radius_m = 0.03125;
};

/// Writes, in order of time: scans, odometry (with its transforms on /tf), radar frames (as
/// wayfare_msgs/RadarScan), the gyro (as sensor_msgs/Imu without specific force), true poses (as
/// geometry_msgs/PoseStamped), wheels (as positions in sensor_msgs/JointState) and the sensors'
/// mounting (on /tf_static); what is known of the wheels and the radar's largest speed as a robot
/// description. `read_robot` restores them bit for bit, but distances of wheels only if their sums
/// are exact, as those of encoder counts; else to the last bit of the distance rolled since the
/// start, without accumulation. Rates and forces of a `unit` replace the recording's gyro on its
/// topic; its magnetic field has a topic of its own. Errors: as of
/// `RecordingWriter::write`; a time of zero, which means "not set" in ROS, or after 2038, where the
/// stamps of ROS 2 end.
[[nodiscard]] Result<void> write_robot(RecordingWriter& writer, const Recording& recording,
                                       const RobotTopics& topics = {}, const UnitRun& unit = {});

}  // namespace wayfare::ros
