#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <wayfare/ros/node.hpp>

#include "support/command_line.hpp"

namespace wayfare::examples {

/// A program that is a node: options from the command line and, where that does not say, from the
/// node's private parameters (`map_period_s` for --map-period-s). Gives the node, connected, or the
/// exit code where the program is to end.
struct StartedNode {
  std::unique_ptr<ros::Node> node;
  int exit_code = 0;
};
[[nodiscard]] StartedNode start_node(int argc, char** argv, const std::string& name,
                                     CommandLine& options);

/// Seconds of a clock that never goes back.
[[nodiscard]] double steady_s();

/// Says where a stamp lies far from the time all nodes go by: a replay without its clock, or
/// computers that disagree.
void check_clock(const ros::Node& node, const ros::Header& header);

void say_all(const ros::Node& node, const std::vector<ros::Notice>& notices);

}  // namespace wayfare::examples
