#include "device.hpp"

#include <array>
#include <chrono>
#include <span>

namespace wayfare::examples {

void add_device_options(CommandLine& app, DeviceArguments& a) {
  app.add_option("--port", a.port, "the device's serial line, such as /dev/ttyUSB0").required();
  app.add_option("--baud", a.line.baud, "bits per second on the line")
      .range(300, 10'000'000)
      .show_default();
  app.add_option("--frame", a.frame, "frame of the messages").show_default();
}

void read_device(ros::Node& node, const DeviceArguments& a, const std::vector<std::uint8_t>& start,
                 const std::function<void(decode::Bytes, LogTime)>& take) {
  std::array<std::uint8_t, 4096> buffer{};
  ros::Notices notices;
  while (node.ok()) {
    auto port = logger::SerialPort::open(a.port, a.line);
    if (!port) {
      notices.add(ros::Severity::warning, "port",
                  "waiting for the device: " + port.error().to_string(), steady_s());
      say_all(node, notices.take());
      node.spin(0.5);
      continue;
    }
    node.say(ros::Severity::info,
             "reading " + a.port + (port->note().empty() ? "" : ": " + port->note()));
    if (auto sent = port->write(start); !sent)
      node.say(ros::Severity::warning, sent.error().to_string());
    while (node.ok()) {
      const auto n = port->read(buffer, std::chrono::milliseconds(50));
      if (!n) {
        node.say(ros::Severity::warning, n.error().to_string());
        break;
      }
      const LogTime now = LogTime::from_nanoseconds(node.now_ns());
      if (*n > 0) take(std::span(buffer).first(*n), now);
      node.spin(0.0);
    }
  }
}

void say_statistics(const ros::Node& node, std::uint64_t messages,
                    const decode::DecoderStatistics& s) {
  node.say(ros::Severity::info, std::to_string(messages) + " messages, " +
                                    std::to_string(s.skipped_bytes) + " of " +
                                    std::to_string(s.bytes) + " bytes outside frames");
}

}  // namespace wayfare::examples
