// A TI millimetre-wave radar as a ROS node.

#include <cstdint>
#include <string>

#include <wayfare/decode/ti_decoder.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/logger/device_decoder.hpp>
#include <wayfare/ros/convert.hpp>

#include "node_program.hpp"

namespace {

using namespace wayfare;

/// Speed of a Doppler bin, which frames before SDK 3 do not contain.
Result<double> speed_step_mps(const std::string& config_file) {
  if (config_file.empty()) return 0.0;
  const auto text = io::read_file(config_file);
  if (!text) return text.error();
  const auto config = decode::parse_ti_config(text->bytes, config_file);
  if (!config) return config.error();
  return decode::limits_of(*config).speed_step_mps;
}

}  // namespace

int main(int argc, char** argv) {
  examples::DeviceArguments device{"", "radar", {921600, logger::ModemLine::keep}};
  std::string config_file;
  examples::CommandLine app(
      "Publish the frames of a TI mmWave radar's data port as wayfare_msgs/RadarScan on 'radar' "
      "and as sensor_msgs/PointCloud2 on 'radar_points'. The radar must be configured.");
  examples::add_device_options(app, device);
  app.add_file("--config", config_file, "the radar's .cfg, needed for speeds before SDK 3");
  app.example("--port /dev/ttyACM1 --config radar.cfg", "an AWR1843");
  const auto started = examples::start_node(argc, argv, "radar_driver_node", app);
  if (!started.node) return started.exit_code;
  ros::Node& node = *started.node;
  const auto step = speed_step_mps(config_file);
  if (!step) {
    node.say(ros::Severity::error, step.error().to_string());
    return 1;
  }
  auto scans = node.publisher<ros::RadarScan>("radar");
  auto clouds = node.publisher<ros::PointCloud2>("radar_points");
  examples::run_driver(node, device, {}, logger::TiStream(device.line.baud, *step),
                       [&](const RadarScan& scan) {
                         scans.publish(ros::message_of(scan, device.frame));
                         if (clouds.subscribers() > 0)
                           clouds.publish(ros::cloud_of(scan, device.frame));
                       });
  return 0;
}
