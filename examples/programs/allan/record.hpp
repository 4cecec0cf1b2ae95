#pragma once

// A record of an inertial unit at rest, taken in reading by reading.

#include <array>
#include <string>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/inertial/allan.hpp>
#include <wayfare/ros/recording.hpp>

namespace wayfare::examples {

struct RecordFormat {
  double rate_hz = 0.0;  ///< 0: from the file's times
  /// A table of float32 without header: gx gy gz in deg/s, ax ay az in g.
  bool raw = false;
  ros::TopicNames topics = {};  ///< of a ROS recording
};

/// Statistics of one axis.
struct AxisRecord {
  AllanRecorder allan;
  AutocorrelationRecorder slow;
};

struct RestRecord {
  double rate_hz = 0.0;
  std::size_t readings = 0;
  std::vector<AxisRecord> axes;  ///< gyro x y z in rad/s, accelerometer x y z in m/s²
  [[nodiscard]] double length_s() const { return static_cast<double>(readings) / rate_hz; }
};

/// From text columns as for gnss_ins, a ROS recording, a float table, or raw float32.
[[nodiscard]] Result<RestRecord> read_rest_record(const std::string& path,
                                                  const RecordFormat& format);

}  // namespace wayfare::examples
