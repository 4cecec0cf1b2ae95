#pragma once

// The wheels of a recording: of sensor_msgs/JointState, with the dimensions of a robot description.

#include <optional>
#include <set>
#include <string>
#include <vector>

#include <wayfare/ros/recording.hpp>

#include "ros/recording/description.hpp"
#include "ros/recording/lanes.hpp"

namespace wayfare::ros {

class WheelReader {
 public:
  WheelReader(const RecordingFile& file, const TopicNames& names) : file_(file), names_(names) {}

  /// Reads joints and description with the other topics. Errors: of the names and numbers given; a
  /// named topic that is missing.
  [[nodiscard]] Result<void> listen(Lanes& lanes, io::Problems& problems);
  /// After the file is read: wheels and radar speed of the recording. Errors: of wheels that were
  /// named.
  [[nodiscard]] Result<void> finish(RobotRun& run) const;

 private:
  /// Positions or velocities of both wheels; of neither if the message has other joints only.
  struct Reading {
    LogTime time;
    bool found = false;
    double left = 0.0, right = 0.0;
  };

  [[nodiscard]] bool named() const;
  [[nodiscard]] Result<void> check() const;
  [[nodiscard]] Result<Reading> read(const JointState& message, LogTime time);
  [[nodiscard]] Result<RobotDescription> description() const;
  [[nodiscard]] Result<void> roll(RobotRun& run) const;
  [[nodiscard]] std::vector<WheelSample> distances(double radius_m, io::Problems& problems) const;
  [[nodiscard]] WheelSample step(const Reading& before, const Reading& now, double radius_m) const;
  [[nodiscard]] Error missing() const;

  const RecordingFile& file_;
  const TopicNames& names_;
  std::string topic_, left_, right_;
  std::string urdf_;
  std::vector<Reading> readings_;
  std::set<std::string> joints_;     ///< names that were read
  std::optional<bool> by_position_;  ///< else by velocity
};

/// Adds a problem if the wheels contradict the gyro in most of the turns.
void compare_with_gyro(const Recording& recording, const std::string& topic,
                       io::Problems& problems);

}  // namespace wayfare::ros
