// Pedestrian dead reckoning as a ROS 1 node.

#include <map>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/ros/pedestrian_node.hpp>

#include "node_program.hpp"

namespace {

using namespace wayfare;
using examples::steady_s;

struct Arguments {
  ros::PedestrianNodeOptions node;
  std::vector<double> forward;
  bool no_magnetometer = false, no_transform = false;
};

void add_options(examples::CommandLine& app, Arguments& a) {
  app.add_option("--odom-frame", a.node.odom_frame, "where odometry counts from").show_default();
  app.add_option("--base-frame", a.node.base_frame, "of who walks").show_default();
  app.add_choice<WalkingAxis>(
      "--axis", a.node.pedestrian.axis,
      {{"sensor", WalkingAxis::sensor}, {"principal", WalkingAxis::principal}},
      "where the direction of walking is taken from: the sensor's own axis, or how the body sways");
  app.add_option("--forward", a.forward, "the sensor's axis that points where the body walks")
      .expected(3);
  app.add_flag("--no-magnetometer", a.no_magnetometer, "do not listen to magnetic_field");
  app.add_flag("--no-transform", a.no_transform, "do not publish odom -> base on /tf");
}

void run(ros::Node& node, const Arguments& a) {
  constexpr std::uint32_t kQueue = 2000;
  ros::PedestrianNode pedestrian(a.node);
  auto odometry = node.publisher<ros::Odometry>("odom");
  auto transforms = node.publisher<ros::TfMessage>("/tf");
  bool clock_checked = false;
  const auto give = [&](const ros::PedestrianNodeOutput& out) {
    for (const ros::Odometry& m : out.odometry) {
      odometry.publish(m);
      const auto& p = m.pose.pose.position;
      if (!a.no_transform)
        transforms.publish(
            {{{m.header, m.child_frame_id, {{p.x, p.y, p.z}, m.pose.pose.orientation}}}});
    }
    examples::say_all(node, out.notices);
  };
  node.subscribe<ros::Imu>("imu", kQueue, [&](const ros::Imu& m) {
    if (!std::exchange(clock_checked, true)) examples::check_clock(node, m.header);
    give(pedestrian.add(m, steady_s()));
  });
  if (!a.no_magnetometer)
    node.subscribe<ros::MagneticField>("magnetic_field", kQueue,
                                       [&](const auto& m) { give(pedestrian.add(m, steady_s())); });
  while (node.ok()) {
    node.spin(0.1);
    give(pedestrian.idle(steady_s()));
  }
}

}  // namespace

int main(int argc, char** argv) {
  Arguments a;
  examples::CommandLine app(
      "Pedestrian dead reckoning as a ROS 1 node. Takes sensor_msgs/Imu on 'imu' and, where there "
      "is one, sensor_msgs/MagneticField on 'magnetic_field'; gives nav_msgs/Odometry on 'odom', "
      "once a step, and its transform.");
  add_options(app, a);
  const auto started = examples::start_node(argc, argv, "pedestrian_node", app);
  if (!started.node) return started.exit_code;
  if (a.forward.size() == 3) {
    a.node.pedestrian.forward = Eigen::Vector3d(a.forward[0], a.forward[1], a.forward[2]);
    if (!(a.node.pedestrian.forward.norm() > 0.0)) {
      started.node->say(ros::Severity::error, "--forward must not be zero");
      return 1;
    }
    a.node.pedestrian.forward.normalize();
  }
  run(*started.node, a);
  return 0;
}
