#pragma once

// The transport of ROS 1: roscpp. C++17, as its headers are.

#include <memory>
#include <string>
#include <vector>

#include <wayfare/ros/detail/raw_node.hpp>

namespace wayfare::ros {

/// The process's only node: roscpp allows one. Removes ROS's own arguments (`scan:=front/scan`,
/// `__name:=…`, `_parameter:=…`) from `arguments` (the first is the program). Nothing is sent yet;
/// connecting waits for the master, at ROS_MASTER_URI, and reports that on standard error.
[[nodiscard]] std::unique_ptr<RawNode> ros1_node(std::vector<std::string>& arguments,
                                                 const std::string& name);

}  // namespace wayfare::ros
