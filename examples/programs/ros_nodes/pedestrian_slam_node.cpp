// Submap SLAM of a walker as a ROS node.

#include "pedestrian_slam/walker_options.hpp"
#include "slam_node_program.hpp"

int main(int argc, char** argv) {
  using namespace wayfare;
  examples::SlamNodeArguments a;
  examples::WalkerOptions walker;
  a.node.system = ros::LaserSystem::pedestrian;
  a.node.odometry = false;
  a.node.imu = true;
  examples::CommandLine app(
      "Submap SLAM of a walker with range finder and inertial unit as a ROS node: steps are the "
      "odometry, corrected by the map, and scans are levelled. Subscribes to sensor_msgs/LaserScan "
      "on 'scan', sensor_msgs/Imu on 'imu', with --no-heading or --no-feedback "
      "sensor_msgs/MagneticField on 'magnetic_field', and transforms; publishes as slam_node.");
  walker.add_options(app);
  examples::add_unit_options(app, a);
  examples::add_slam_options(app, a, "pedestrian_slam");
  examples::add_resolution(app, a);
  examples::add_threads(app, a);
  app.example("scan:=head/scan imu:=head/imu", "a range finder and a unit on the head");
  return examples::run_slam_node(argc, argv, "pedestrian_slam_node", app, a.node, [&] {
    const bool by_map = !walker.no_feedback && !walker.no_heading;
    a.node.magnetometer = !walker.no_magnetometer && !by_map;
    if (auto ok = walker.apply(a.node.walker); !ok) return ok;
    const auto ok =
        examples::complete(a, examples::submap_slam_fields(a.node.slam), a.node.slam.grid);
    return ok ? examples::check_submap_slam(a.node.slam) : ok;
  });
}
