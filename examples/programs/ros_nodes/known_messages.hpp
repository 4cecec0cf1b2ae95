#pragma once

// The message types of messages.hpp by name, for programs on topics of any type.

#include <functional>
#include <map>
#include <string>
#include <string_view>

#include <wayfare/ros/node.hpp>

namespace wayfare::examples {

/// A message type whose messages are not looked into.
struct MessageKind {
  ros::TopicType type;
  std::string definition;  ///< of ROS 2
  std::function<Result<std::string>(std::string_view, ros::Dialect from, ros::Dialect to)> convert;
};

/// By ROS 1 names.
[[nodiscard]] const std::map<std::string, MessageKind>& known_messages();

}  // namespace wayfare::examples
