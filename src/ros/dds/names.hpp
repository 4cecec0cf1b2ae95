#pragma once

// Names of topics and types in ROS 2 and in DDS.

#include <string>
#include <string_view>

#include <wayfare/core/result.hpp>

namespace wayfare::ros::dds {

/// `sensor_msgs/Imu` -> `sensor_msgs::msg::dds_::Imu_`.
[[nodiscard]] std::string dds_type(std::string_view ros1_name);
/// The inverse; `a::srv::dds_::B_` gives `a/srv/B`. A name that is not of ROS is kept.
[[nodiscard]] std::string ros1_type(std::string_view dds_name);

/// A node's name and namespace ("/" or "/robot").
struct NodeName {
  std::string name, ns = "/";
};

/// The topic with its namespaces: `scan` -> `/robot/scan`, `~/map` -> `/robot/node/map`. Errors:
/// not a name of ROS 2: letters, digits and _ between slashes, no digit first.
[[nodiscard]] Result<std::string> absolute(std::string_view topic, const NodeName& node);

/// Whether it is a name without slashes.
[[nodiscard]] bool is_token(std::string_view text);

}  // namespace wayfare::ros::dds
