// Hector SLAM as a ROS node.

#include "hector_slam/option_fields.hpp"
#include "slam_node_program.hpp"

int main(int argc, char** argv) {
  using namespace wayfare;
  examples::SlamNodeArguments a;
  bool odometry = false;
  a.node.system = ros::LaserSystem::hector;
  examples::CommandLine app(
      "Hector SLAM as a ROS node: each scan is matched to one map at several resolutions, "
      "without "
      "loop closures. Subscribes to sensor_msgs/LaserScan on 'scan', with --imu sensor_msgs/Imu on "
      "'imu', with --odometry nav_msgs/Odometry on 'odom', and transforms; publishes as "
      "slam_node.");
  app.add_flag("--odometry", odometry,
               "wait for odometry; without, odom -> base is published by the node");
  app.add_flag("--imu", a.node.imu, "level the scans by an inertial unit, and fuse it");
  examples::add_unit_options(app, a);
  examples::add_slam_options(app, a, "hector_slam");
  app.example("--imu scan:=front/scan", "a walker or a rolling vehicle with an inertial unit");
  return examples::run_slam_node(argc, argv, "hector_node", app, a.node, [&] {
    a.node.odometry = odometry;
    return examples::complete(a, examples::hector_slam_fields(a.node.hector), a.node.hector.map);
  });
}
