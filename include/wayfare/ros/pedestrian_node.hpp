#pragma once

// Pedestrian dead reckoning as a node, without the interface to ROS.

#include <optional>
#include <string>
#include <vector>

#include <wayfare/pedestrian/pedestrian.hpp>
#include <wayfare/ros/convert.hpp>
#include <wayfare/ros/detail/node_output.hpp>
#include <wayfare/ros/messages.hpp>

namespace wayfare::ros {

struct PedestrianNodeOptions {
  PedestrianParameters pedestrian{};
  std::string odom_frame = "odom", base_frame = "base_link";
  double jump_back_s = 1.0;  ///< samples this much earlier than the last restart the reckoning
};

struct PedestrianNodeOutput {
  std::vector<Odometry> odometry;  ///< one per step, with covariance
  std::vector<Notice> notices;
};

/// `now_s` is of a monotonic clock. Not thread-safe.
class PedestrianNode {
 public:
  explicit PedestrianNode(PedestrianNodeOptions options = {});

  [[nodiscard]] PedestrianNodeOutput add(const Imu& message, double now_s);
  [[nodiscard]] PedestrianNodeOutput add(const MagneticField& message, double now_s);
  /// Call it a few times per second: reports missing input.
  [[nodiscard]] PedestrianNodeOutput idle(double now_s);

 private:
  void take(const MargSample& sample, double now_s, PedestrianNodeOutput& out);

  PedestrianNodeOptions options_;
  Pedestrian pedestrian_;
  std::optional<LogTime> last_;
  std::optional<double> heard_s_;
  std::optional<PedestrianPose> before_;
  Notices notices_;
};

/// One step's pose as odometry; the speed is that since `before`.
[[nodiscard]] Odometry odometry_message(const PedestrianPose& pose,
                                        const std::optional<PedestrianPose>& before,
                                        const std::string& odom_frame,
                                        const std::string& base_frame);

}  // namespace wayfare::ros
