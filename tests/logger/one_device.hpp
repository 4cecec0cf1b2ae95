#pragma once

// A logger's options for one device on a pseudo-terminal.

#include <string>
#include <utility>

#include "logger/simulated_devices.hpp"

namespace wayfare::testing {

inline logger::SensorOptions sensor(const logger::DeviceDescription& device,
                                    const std::string& port) {
  logger::SensorOptions options;
  options.device = device;
  options.port = port;
  return options;
}

/// One device of kind "raw" on a pseudo-terminal.
struct OneDevice {
  OneDevice() : terminal(std::move(*logger::PseudoTerminal::open())) {
    options.folder = folder.path().string();
    options.sensors = {sensor({"unit", "raw", 115200, ""}, terminal.path())};
    options.status_every = std::chrono::milliseconds(50);
  }
  void send(const std::string& bytes) {
    const auto* data = reinterpret_cast<const std::uint8_t*>(bytes.data());
    ASSERT_EQ(terminal.write({data, bytes.size()}, std::chrono::seconds(2)).value_or(0),
              bytes.size());
  }
  TemporaryFolder folder;
  logger::PseudoTerminal terminal;
  logger::LoggerOptions options;
};

inline bool has_read(const logger::Logger& logger, std::uint64_t bytes) {
  return wait_for(std::chrono::seconds(20),
                  [&] { return logger.status().sensors[0].bytes == bytes; });
}

}  // namespace wayfare::testing
