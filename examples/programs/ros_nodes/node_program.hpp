#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <wayfare/core/time.hpp>
#include <wayfare/decode/stream_decoder.hpp>
#include <wayfare/logger/serial_port.hpp>
#include <wayfare/ros/node.hpp>

#include "support/command_line.hpp"

namespace wayfare::examples {

/// A connected node, or the exit code if the program is to end. Options are taken from the command
/// line, else from the node's parameters (`map_period_s` for --map-period-s). Of ROS 2, unless
/// ROS_VERSION or ROS_MASTER_URI say ROS 1, or only one of the two was built.
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

/// Warns of messages that were refused or lost.
void say_counts(const ros::Node& node);

void say_all(const ros::Node& node, const std::vector<ros::Notice>& notices);

/// A device on a serial line.
struct DeviceArguments {
  std::string port, frame;
  logger::SerialOptions line;
};
void add_device_options(CommandLine& app, DeviceArguments& arguments);

/// Reads the device until the node ends; reopens a lost line. `start` is sent after each opening;
/// `take(bytes, arrived)` receives the bytes and returns the number of messages so far. A line
/// without bytes, and bytes without messages, are reported.
void read_device(ros::Node& node, const DeviceArguments& arguments,
                 const std::vector<std::uint8_t>& start,
                 const std::function<std::uint64_t(decode::Bytes, LogTime)>& take);

/// Logs the number of messages and of skipped bytes.
void say_statistics(const ros::Node& node, std::uint64_t messages,
                    const decode::DecoderStatistics& statistics);

/// Passes what `stream` decodes of the device to `publish`, until the node ends.
template <class Stream, class Publish>
void run_driver(ros::Node& node, const DeviceArguments& device,
                const std::vector<std::uint8_t>& start, Stream stream, Publish publish) {
  std::uint64_t messages = 0;
  read_device(node, device, start, [&](decode::Bytes bytes, LogTime arrived) {
    stream.feed(bytes, arrived, [&](const auto&... measured) {
      publish(measured...);
      ++messages;
    });
    return messages;
  });
  say_statistics(node, messages, stream.statistics());
}

}  // namespace wayfare::examples
