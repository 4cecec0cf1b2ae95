// SLAM as a ROS node: submap SLAM of laser scans, or the particle filter of radar or both.

#include "slam_node_program.hpp"

namespace {

using namespace wayfare;

struct Arguments : examples::SlamNodeArguments {
  bool no_odometry = false;
  std::vector<double> radar;  ///< x, y in m, heading in degrees
  std::size_t particles = 0;
};

void add_options(examples::CommandLine& app, Arguments& a) {
  app.add_choice<SlamSensors>(
      "--sensors", a.node.sensors,
      {{"lidar", SlamSensors::lidar}, {"radar", SlamSensors::radar}, {"both", SlamSensors::both}},
      "lidar: submap SLAM of laser scans; radar, both: the particle filter, with odometry");
  app.add_option("--particles", a.particles, "of the filter; by default 30, for radar alone 10")
      .range(1, 100000);
  examples::add_slam_options(app, a, "submap_slam");
  app.add_option("--radar", a.radar, "as --laser, for the radar").expected(3);
  app.add_flag("--no-odometry", a.no_odometry,
               "do not wait for odometry; odom -> base is published by the node");
  app.add_flag("--imu", a.node.imu, "with --no-odometry: rotation from the inertial unit");
  examples::add_resolution(app, a);
  examples::add_threads(app, a);
}

Result<void> complete(Arguments& a) {
  const bool filter = a.node.sensors != SlamSensors::lidar;
  if (filter && (a.no_odometry || a.node.imu || !a.config.empty()))
    return Error{ErrorCode::invalid,
                 "--no-odometry, --imu and --config are only for --sensors lidar"};
  a.node.odometry = !a.no_odometry;
  a.node.filter.threads = a.node.slam.threads;
  a.node.filter.particles = a.particles > 0                        ? a.particles
                            : a.node.sensors == SlamSensors::radar ? 10
                                                                   : 30;
  if (a.radar.size() == 3)
    a.node.T_base_radar = Transform2<frame::Base, frame::Radar>(examples::pose_of(a.radar));
  const auto ok =
      examples::complete(a, examples::submap_slam_fields(a.node.slam), a.node.slam.grid);
  return ok ? examples::check_submap_slam(a.node.slam) : ok;
}

}  // namespace

int main(int argc, char** argv) {
  Arguments arguments;
  examples::CommandLine app(
      "Submap SLAM with laser scans, or the particle filter with radar or both, as a ROS node. "
      "Subscribes to sensor_msgs/LaserScan on 'scan', wayfare_msgs/RadarScan on 'radar' or "
      "sensor_msgs/PointCloud2 on 'radar_points', whichever arrives first, nav_msgs/Odometry on "
      "'odom' or, with laser scans only, sensor_msgs/Imu on 'imu', and transforms; publishes "
      "nav_msgs/OccupancyGrid on 'map' and nav_msgs/Path on 'path' (both latched), "
      "geometry_msgs/PoseWithCovarianceStamped on 'pose', with the particle filter "
      "geometry_msgs/PoseArray on 'particle_cloud', and the transform from map to odom "
      "(REP-105).");
  add_options(app, arguments);
  app.example("", "submap SLAM on the topics scan and odom");
  app.example("--no-odometry --imu scan:=front/scan", "without wheels, with an inertial unit");
  return examples::run_slam_node(argc, argv, "slam_node", app, arguments.node,
                                 [&] { return complete(arguments); });
}
