#pragma once

// A logger's recordings as measurements.

#include <cstddef>
#include <string>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/sensors/marg.hpp>
#include <wayfare/sensors/recording.hpp>

namespace wayfare::logger {

/// Whether a path has a recording's suffix, `.mcap`.
[[nodiscard]] bool is_recording(const std::string& path);

struct RecordedMarg {
  MargRecording samples;  ///< in order of time
  std::string topic;
  io::Problems problems;
};

/// The samples of an inertial unit: messages wayfare.Imu of `topic`, which may be empty if there is
/// only one such channel. Errors: the file cannot be read, the topic is missing, or there are
/// several (which are listed).
[[nodiscard]] Result<RecordedMarg> read_marg_recording(const std::string& path,
                                                       const std::string& topic = {});

struct RecordedRobot {
  Recording recording;  ///< laser scans and radar frames, each from the first such channel
  std::string scan_topic, radar_topic;
  io::Problems problems;
};

/// The scans of a recording (foxglove.LaserScan, foxglove.PointCloud). Errors: the file cannot be
/// read, or has neither.
[[nodiscard]] Result<RecordedRobot> read_robot_recording(const std::string& path);

}  // namespace wayfare::logger
