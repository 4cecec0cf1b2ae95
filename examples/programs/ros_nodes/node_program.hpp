#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <wayfare/ros/node.hpp>

#include "support/command_line.hpp"

namespace wayfare::examples {

/// A connected node, or the exit code if the program is to end. Options are taken from the command
/// line, else from the node's private parameters (`map_period_s` for --map-period-s).
struct StartedNode {
  std::unique_ptr<ros::Node> node;
  int exit_code = 0;
};
[[nodiscard]] StartedNode start_node(int argc, char** argv, const std::string& name,
                                     CommandLine& options);

/// Seconds of a monotonic clock.
[[nodiscard]] double steady_s();

/// Logs a stamp that is far from the node's time: a replay without its clock, or clocks that
/// differ.
void check_clock(const ros::Node& node, const ros::Header& header);

void say_all(const ros::Node& node, const std::vector<ros::Notice>& notices);

}  // namespace wayfare::examples
