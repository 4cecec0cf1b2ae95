#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include <wayfare/core/time.hpp>
#include <wayfare/decode/stream_decoder.hpp>
#include <wayfare/logger/serial_port.hpp>

#include "node_program.hpp"

namespace wayfare::examples {

/// A device on a serial line.
struct DeviceArguments {
  std::string port, frame;
  logger::SerialOptions line;
};
void add_device_options(CommandLine& app, DeviceArguments& arguments);

/// Reads the device until the node ends; reopens a lost line. `start` is sent after each opening;
/// `take(bytes, arrived)` receives the bytes.
void read_device(ros::Node& node, const DeviceArguments& arguments,
                 const std::vector<std::uint8_t>& start,
                 const std::function<void(decode::Bytes, LogTime)>& take);

/// Logs the number of messages and of skipped bytes.
void say_statistics(const ros::Node& node, std::uint64_t messages,
                    const decode::DecoderStatistics& statistics);

}  // namespace wayfare::examples
