// Pedestrian dead reckoning as a ROS node.

#include <map>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/ros/nodes.hpp>

#include "node_program.hpp"
#include "pedestrian/step_length_options.hpp"

namespace {

using namespace wayfare;
using examples::steady_s;

struct Arguments {
  ros::PedestrianNodeOptions node;
  examples::StepLengthOptions length;
  std::vector<double> forward;
  bool no_magnetometer = false, no_transform = false;
};

void add_options(examples::CommandLine& app, Arguments& a) {
  app.add_option("--odom-frame", a.node.odom_frame, "of the odometry: its origin").show_default();
  app.add_option("--base-frame", a.node.base_frame, "of the walker").show_default();
  app.add_choice<WalkingAxis>(
      "--axis", a.node.pedestrian.axis,
      {{"sensor", WalkingAxis::sensor}, {"principal", WalkingAxis::principal}},
      "direction of walking: the sensor's axis, or the principal axis of the body's motion");
  app.add_option("--forward", a.forward, "the sensor's axis in the direction of walking")
      .expected(3);
  a.length.add_options(app);
  app.add_flag("--no-magnetometer", a.no_magnetometer, "do not subscribe to magnetic_field");
  app.add_flag("--no-transform", a.no_transform, "do not publish odom -> base on /tf");
}

void run(ros::Node& node, const Arguments& a) {
  const ros::Qos queue = ros::Qos::queue(2000);
  ros::PedestrianNode pedestrian(a.node);
  auto odometry = node.publisher<ros::Odometry>("odom");
  auto transforms = node.publisher<ros::TfMessage>("/tf");
  bool clock_checked = false;
  const auto publish = [&](const ros::PedestrianNodeOutput& out) {
    for (const ros::Odometry& m : out.odometry) {
      odometry.publish(m);
      const auto& p = m.pose.pose.position;
      if (!a.no_transform)
        transforms.publish(
            {{{m.header, m.child_frame_id, {{p.x, p.y, p.z}, m.pose.pose.orientation}}}});
    }
    examples::say_all(node, out.notices);
  };
  node.subscribe<ros::Imu>("imu", queue, [&](const ros::Imu& m) {
    if (!std::exchange(clock_checked, true)) examples::check_clock(node, m.header);
    publish(pedestrian.add(m, steady_s()));
  });
  if (!a.no_magnetometer)
    node.subscribe<ros::MagneticField>(
        "magnetic_field", queue, [&](const auto& m) { publish(pedestrian.add(m, steady_s())); });
  while (node.ok()) {
    node.spin(0.1);
    publish(pedestrian.idle(steady_s()));
  }
  examples::say_counts(node);
}

}  // namespace

int main(int argc, char** argv) {
  Arguments a;
  examples::CommandLine app(
      "Pedestrian dead reckoning as a ROS node. Subscribes to sensor_msgs/Imu on 'imu' and, "
      "optionally, sensor_msgs/MagneticField on 'magnetic_field'; publishes nav_msgs/Odometry on "
      "'odom' at each step, and its transform.");
  add_options(app, a);
  app.example("--length frequency --height 1.75", "steps of a person of 1.75 m");
  const auto started = examples::start_node(argc, argv, "pedestrian_node", app);
  if (!started.node) return started.exit_code;
  const auto length = a.length.model();
  if (!length) {
    started.node->say(ros::Severity::error, length.error().to_string());
    return 1;
  }
  a.node.pedestrian.length = *length;
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
