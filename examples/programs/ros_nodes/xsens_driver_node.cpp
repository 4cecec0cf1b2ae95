// An Xsens MTi, or a tracker of an Awinda station, as a ROS node.

#include <cstdint>
#include <cstdio>
#include <optional>
#include <string>
#include <utility>

#include <wayfare/logger/device_decoder.hpp>
#include <wayfare/ros/convert.hpp>

#include "node_program.hpp"

namespace {

using namespace wayfare;

/// Chooses what is published of a device.
class Choice {
 public:
  /// Of the trackers of a station the named one, else the first that is heard. An MTi has no
  /// identifier.
  Choice(const ros::Node& node, std::optional<std::uint32_t> tracker)
      : node_(node), tracker_(tracker) {}

  [[nodiscard]] bool takes(std::optional<std::uint32_t> tracker) {
    if (!tracker) return true;
    if (!tracker_) {
      tracker_ = tracker;
      node_.say(ros::Severity::info, "publishes tracker " + name_of(*tracker));
    }
    if (tracker == tracker_) return true;
    warn(name_of(*tracker), "left out tracker " + name_of(*tracker) + ": publishes " +
                                name_of(*tracker_) + ", see --tracker");
    return false;
  }
  [[nodiscard]] bool is_complete(const MargSample& s) {
    if (s.angular_rate_radps.allFinite() && s.specific_force_mps2.allFinite()) return true;
    warn("incomplete",
         "left out a sample without turn rate or specific force: the device must "
         "send both in one message");
    return false;
  }

 private:
  static std::string name_of(std::uint32_t tracker) {
    char text[9];
    std::snprintf(text, sizeof text, "%08X", tracker);
    return text;
  }
  void warn(const std::string& about, std::string text) {
    notices_.add(ros::Severity::warning, about, std::move(text), examples::steady_s());
    examples::say_all(node_, notices_.take());
  }

  const ros::Node& node_;
  std::optional<std::uint32_t> tracker_;
  ros::Notices notices_{600.0};
};

}  // namespace

int main(int argc, char** argv) {
  examples::DeviceArguments device{"", "imu", {115200, logger::ModemLine::keep}};
  std::string tracker;
  examples::CommandLine app(
      "Publish the samples of an Xsens MTi (MTData2), or of a tracker of an Awinda station, as "
      "sensor_msgs/Imu on 'imu' and sensor_msgs/MagneticField on 'magnetic_field'. The device must "
      "be configured and measuring.");
  examples::add_device_options(app, device);
  app.add_option("--tracker", tracker,
                 "of a station: the tracker to publish, eight hexadecimal digits; by default the "
                 "first that is heard");
  app.example("--port /dev/ttyUSB0", "an MTi, or the first tracker of a station");
  const auto started = examples::start_node(argc, argv, "xsens_driver_node", app);
  if (!started.node) return started.exit_code;
  ros::Node& node = *started.node;
  const bool hexadecimal =
      tracker.size() == 8 && tracker.find_first_not_of("0123456789ABCDEFabcdef") == tracker.npos;
  if (!tracker.empty() && !hexadecimal) {
    node.say(ros::Severity::error, "--tracker must be eight hexadecimal digits, not " + tracker);
    return 1;
  }
  Choice choice(node,
                hexadecimal
                    ? std::optional(static_cast<std::uint32_t>(std::stoul(tracker, nullptr, 16)))
                    : std::nullopt);
  auto samples = node.publisher<ros::Imu>("imu");
  auto fields = node.publisher<ros::MagneticField>("magnetic_field");
  examples::run_driver(
      node, device, {}, logger::XsensStream(device.line.baud),
      [&](std::optional<std::uint32_t> from, const MargSample& s) {
        if (!choice.takes(from) || !choice.is_complete(s)) return;
        samples.publish(ros::message_of(
            ImuSample{s.time, s.angular_rate_radps, s.specific_force_mps2}, device.frame));
        if (s.magnetic_field_uT.allFinite())
          fields.publish(ros::magnetic_message_of(s.magnetic_field_uT, s.time, device.frame));
      });
  return 0;
}
