#pragma once

// A logger's recordings as the measurements the systems take.

#include <cstddef>
#include <string>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/sensors/marg.hpp>
#include <wayfare/sensors/recording.hpp>

namespace wayfare::logger {

/// Whether a path's name ends as a recording's does: `.mcap`.
[[nodiscard]] bool is_recording(const std::string& path);

struct RecordedMarg {
  MargRecording samples;  ///< in order of time
  std::string topic;
  io::Problems problems;
};

/// The samples of an inertial unit: messages wayfare.Imu of `topic`, which may be left empty where
/// there is one such channel. Errors: the file cannot be read, no such topic or several (they are
/// named).
[[nodiscard]] Result<RecordedMarg> read_marg_recording(const std::string& path,
                                                       const std::string& topic = {});

struct RecordedRobot {
  Recording recording;  ///< laser scans and radar frames, each of the first such channel
  std::string scan_topic, radar_topic;
  io::Problems problems;
};

/// The scans of a recording (foxglove.LaserScan, foxglove.PointCloud). Errors: the file cannot be
/// read, or has neither.
[[nodiscard]] Result<RecordedRobot> read_robot_recording(const std::string& path);

}  // namespace wayfare::logger
