#pragma once

// What a ROS 1 bag (format 2.0, "#ROSBAG V2.0") is made of: connections, each of one topic and one
// kind of message, and the messages that came by them.

#include <cstdint>
#include <string>
#include <string_view>

#include <wayfare/core/time.hpp>

namespace wayfare::io {

struct BagConnection {
  std::uint32_t id = 0;
  std::string topic = {};
  std::string type = {};        ///< such as sensor_msgs/Imu
  std::string md5 = {};         ///< of the type's definition
  std::string definition = {};  ///< of the type and of those within it
  bool latching = false;        ///< the last message is repeated to whoever comes late
};

/// One message as a reader delivers it; `connection` and `data` are gone when the callable returns.
struct BagMessage {
  const BagConnection* connection = nullptr;
  LogTime time;  ///< when it was received
  std::string_view data;
};

}  // namespace wayfare::io
