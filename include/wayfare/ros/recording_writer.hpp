#pragma once

// Writing recordings of ROS messages, without ROS: in the format of ROS 2 (MCAP with CDR) or as a
// ROS 1 bag.

#include <memory>
#include <span>
#include <string>
#include <string_view>

#include <wayfare/core/result.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/ros/serialise.hpp>
#include <wayfare/sensors/marg.hpp>
#include <wayfare/sensors/recording.hpp>

namespace wayfare::ros {

class RecordingWriter {
 public:
  /// The format follows the name: `.mcap` or `.bag`. Errors: another suffix; the file exists (see
  /// `options`), or cannot be written.
  [[nodiscard]] static Result<RecordingWriter> create(const std::string& path,
                                                      const io::WriteOptions& options = {});
  RecordingWriter(RecordingWriter&&) noexcept;
  RecordingWriter& operator=(RecordingWriter&&) noexcept;
  ~RecordingWriter();

  /// Errors: a time before 1970, or of the disk.
  template <Message M>
  [[nodiscard]] Result<void> write(const std::string& topic, LogTime received, const M& message) {
    if (!knows(topic))
      if (auto added = add(topic, M::kType, definition<M>(dialect())); !added) return added;
    return write_bytes(topic, received, to_bytes(message, dialect()));
  }

  /// Closes the file; nothing can be written afterwards. A bag is complete on the disk only now.
  [[nodiscard]] Result<void> close();

 private:
  struct Impl;
  explicit RecordingWriter(std::unique_ptr<Impl> impl);
  [[nodiscard]] Dialect dialect() const;
  [[nodiscard]] bool knows(const std::string& topic) const;
  [[nodiscard]] Result<void> add(const std::string& topic, const MessageType& type,
                                 const std::string& definition);
  [[nodiscard]] Result<void> write_bytes(const std::string& topic, LogTime received,
                                         std::string_view data);

  std::unique_ptr<Impl> impl_;
};

/// An inertial unit recorded with a robot.
struct UnitRun {
  std::span<const MargSample> samples = {};  ///< in order of time
  SE2d T_base_unit = {};
};

struct RobotTopics {
  std::string scan = "/scan", odometry = "/odom", radar = "/radar", imu = "/imu";
  std::string truth = "/truth", magnetometer = "/magnetic_field";
  std::string map_frame = "map", odom_frame = "odom", base_frame = "base_link";
  std::string laser_frame = "laser", radar_frame = "radar", imu_frame = "imu";
};

/// Writes, in order of time: scans, odometry (with its transforms on /tf), radar frames (as
/// wayfare_msgs/RadarScan), the gyro (as sensor_msgs/Imu without specific force), true poses (as
/// geometry_msgs/PoseStamped) and the sensors' mounting (on /tf_static). `read_robot` restores them
/// bit for bit. Rates and forces of a `unit` replace the recording's gyro on its topic; its
/// magnetic field has a topic of its own. Wheels have no ROS message and are dropped. Errors: as of
/// `RecordingWriter::write`; a time of zero, which means "not set" in ROS.
[[nodiscard]] Result<void> write_robot(RecordingWriter& writer, const Recording& recording,
                                       const RobotTopics& topics = {}, const UnitRun& unit = {});

}  // namespace wayfare::ros
