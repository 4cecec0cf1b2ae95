#pragma once

// metadata.yaml, by which `ros2 bag` knows a folder with a recording.

#include <cstdint>
#include <string>
#include <vector>

#include <wayfare/core/time.hpp>
#include <wayfare/ros/qos.hpp>

namespace wayfare::examples {

/// Of rosbag2's integers and "never" for what has no deadline.
[[nodiscard]] std::string offered_qos_profile(const ros::Qos& qos);

struct RecordedTopic {
  std::string name, type;  ///< as ROS 2 has it: sensor_msgs/msg/Imu
  std::string qos;         ///< of offered_qos_profile
  std::uint64_t messages = 0;
};

/// Version 5 of the file, of ROS 2 Humble; later ones read it.
[[nodiscard]] std::string rosbag2_metadata(const std::string& file,
                                           const std::vector<RecordedTopic>& topics, LogTime first,
                                           LogTime last);

}  // namespace wayfare::examples
