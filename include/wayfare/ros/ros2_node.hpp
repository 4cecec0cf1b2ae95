#pragma once

// The transport of ROS 2: DDS, by Cyclone DDS, without ROS.

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/ros/detail/raw_node.hpp>

namespace wayfare::ros {

/// Where a node is found, if not by its environment.
struct Ros2Options {
  std::optional<unsigned> domain = {};  ///< 0 to 232; none: ROS_DOMAIN_ID, else 0
  /// Whether other computers may find it. None: by ROS_LOCALHOST_ONLY=0, or by
  /// ROS_AUTOMATIC_DISCOVERY_RANGE=SUBNET or SYSTEM_DEFAULT; without these this computer only.
  std::optional<bool> network = {};
};

/// Takes ROS's own arguments (`--ros-args -r scan:=/front/scan -r __ns:=/robot -p rate:=2.0
/// --params-file FILE`) from `arguments` (the first is the program). Nothing is sent yet.
/// CYCLONEDDS_URI is Cyclone's own configuration and is read after ours. Errors: an argument, name
/// or file that ROS 2 would not accept; a domain outside 0 to 232.
[[nodiscard]] Result<std::unique_ptr<RawNode>> ros2_node(std::vector<std::string>& arguments,
                                                         const std::string& name,
                                                         const Ros2Options& options = {});

/// The type hash of a message type of messages.hpp as distributions from Iron on announce it,
/// "RIHS01_" and 64 digits; empty for other types. `ros1_name` is such as sensor_msgs/Imu.
[[nodiscard]] std::string_view type_hash(std::string_view ros1_name);

}  // namespace wayfare::ros
