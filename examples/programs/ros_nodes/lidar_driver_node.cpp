// An RPLIDAR as a ROS node.

#include <cstdint>
#include <map>
#include <vector>

#include <wayfare/decode/rplidar_stream.hpp>
#include <wayfare/decode/rplidar_sweep.hpp>
#include <wayfare/ros/convert.hpp>

#include "node_program.hpp"

int main(int argc, char** argv) {
  using namespace wayfare;
  examples::DeviceArguments device{"", "laser", {115200, logger::ModemLine::keep}};
  decode::RplidarScanOptions scan;
  bool start = false;
  examples::CommandLine app(
      "Publish the revolutions of a SLAMTEC RPLIDAR as sensor_msgs/LaserScan on 'scan'.");
  examples::add_device_options(app, device);
  app.add_flag("--start", start, "start scanning once the line is open");
  app.add_choice<logger::ModemLine>("--dtr", device.line.dtr,
                                    {{"keep", logger::ModemLine::keep},
                                     {"on", logger::ModemLine::on},
                                     {"off", logger::ModemLine::off}},
                                    "the modem line; off starts the motor of an A1");
  app.add_number("--beams", scan.beams, 8, 100000, "per scan, evenly distributed");
  app.example("--port /dev/ttyUSB0 --start", "an RPLIDAR that is to begin scanning");
  const auto started = examples::start_node(argc, argv, "lidar_driver_node", app);
  if (!started.node) return started.exit_code;
  ros::Node& node = *started.node;
  auto scans = node.publisher<ros::LaserScan>("scan");
  const std::vector<std::uint8_t> request =
      start ? std::vector<std::uint8_t>{0xA5, 0x20} : std::vector<std::uint8_t>{};
  examples::run_driver(
      node, device, request, decode::RplidarStream(device.line.baud),
      [&](const decode::RplidarRevolution& turn) {
        scans.publish(ros::message_of(decode::to_laser_sweep(turn, scan), device.frame));
      });
  return 0;
}
