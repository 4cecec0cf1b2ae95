#pragma once

// The arguments of ROS 2 on a command line.

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <wayfare/core/result.hpp>

#include "ros/dds/names.hpp"

namespace wayfare::ros::dds {

/// What the arguments of a node say.
struct RosArguments {
  NodeName node;
  std::vector<std::pair<std::string, std::string>> remappings = {};  ///< of topics, as written
  std::vector<std::pair<std::string, std::string>> parameters = {};  ///< each name once

  /// The topic with its namespaces, after remapping.
  [[nodiscard]] Result<std::string> topic(std::string_view name) const;
  /// A parameter; empty if it is not set.
  [[nodiscard]] std::string parameter(std::string_view name) const;
};

/// Takes `--ros-args … [--]` from the arguments, the first of which is the program. `name` is the
/// node's unless they say another.
[[nodiscard]] Result<RosArguments> take_ros_arguments(std::vector<std::string>& arguments,
                                                      const std::string& name);

}  // namespace wayfare::ros::dds
