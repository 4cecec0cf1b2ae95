#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/ros/nodes.hpp>
#include "room_drive.hpp"

namespace wayfare::testing {

/// A node with all its output, and its own clock.
class Driven {
 public:
  explicit Driven(ros::SlamNodeOptions options = {}) : node(std::move(options)) {}

  void transforms(const Recording& of = room_drive()) { node.add(mounting(of)); }
  void odometry(const OdometrySample& sample) {
    node.add(ros::message_of(sample, kOdomFrame, "base_link"), now_s);
    work();
  }
  void scan(const LaserScan& scan) {
    node.add(ros::message_of(scan, "laser"), now_s);
    work();
  }
  void sample(const MargSample& s) {
    node.add(ros::message_of(ImuSample{s.time, s.angular_rate_radps, s.specific_force_mps2}, "imu"),
             now_s);
    work();
  }
  void radar(const RadarScan& scan) {
    node.add(ros::message_of(scan, "radar"), now_s);
    work();
  }
  void cloud(const RadarScan& scan) {
    node.add(ros::cloud_of(scan, "radar"), now_s);
    work();
  }
  void wait(double seconds) {
    for (double waited = 0.0; waited < seconds; waited += step_s) work();
  }
  void work() {
    now_s += step_s;
    do take(node.work(now_s));
    while (node.busy());
  }
  void take(const ros::SlamNodeOutput& out) {
    poses.insert(poses.end(), out.poses.begin(), out.poses.end());
    transforms_out.insert(transforms_out.end(), out.transforms.begin(), out.transforms.end());
    if (out.particles) particles.push_back(*out.particles);
    if (out.map) map = out.map;
    if (out.path) path = out.path;
    for (const ros::Notice& n : out.notices) said += n.text + "\n";
  }

  ros::SlamNode node;
  double now_s = 100.0, step_s = 0.05;
  std::vector<ros::PoseWithCovarianceStamped> poses;
  std::vector<ros::PoseArray> particles;
  std::vector<ros::TransformStamped> transforms_out;
  std::optional<ros::OccupancyGrid> map;
  std::optional<ros::Path> path;
  std::string said;
};

}  // namespace wayfare::testing
