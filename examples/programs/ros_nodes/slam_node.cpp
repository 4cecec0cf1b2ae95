// SLAM as a ROS 1 node: submap SLAM of laser scans, or the particle filter of radar or both.

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/ros/nodes.hpp>

#include "node_program.hpp"
#include "support/option_fields.hpp"

namespace {

using namespace wayfare;
using examples::steady_s;

struct Arguments {
  ros::SlamNodeOptions slam;
  bool no_odometry = false;
  std::vector<double> laser, radar;  ///< x, y in m, heading in degrees
  std::size_t particles = 0;
  std::string config;
};

void add_options(examples::CommandLine& app, Arguments& a) {
  auto& s = a.slam;
  app.add_choice<SlamSensors>(
      "--sensors", s.sensors,
      {{"lidar", SlamSensors::lidar}, {"radar", SlamSensors::radar}, {"both", SlamSensors::both}},
      "lidar: submap SLAM of laser scans; radar, both: the particle filter, with odometry");
  app.add_option("--particles", a.particles, "of the filter; by default 30, for radar alone 10")
      .range(1, 100000);
  app.add_option("--map-frame", s.map_frame, "of map, pose and path").show_default();
  app.add_option("--odom-frame", s.odom_frame, "of the odometry").show_default();
  app.add_option("--base-frame", s.base_frame, "of the robot").show_default();
  app.add_option(
         "--laser", a.laser,
         "pose of the laser on the robot: x and y in metres, heading in degrees; by default "
         "from the transforms")
      .expected(3);
  app.add_option("--radar", a.radar, "the same for the radar").expected(3);
  app.add_flag("--no-odometry", a.no_odometry,
               "do not wait for odometry; odom -> base is published by the node");
  app.add_flag("--imu", s.imu, "with --no-odometry: rotation from the inertial unit");
  app.add_positive("--map-period-s", s.map_period_s, "interval between maps");
  app.add_option("--patience-s", s.patience_s, "longest time a scan waits for odometry")
      .not_negative()
      .show_default();
  app.add_positive("--settle-s", s.settle_s,
                   "time without scans after which the graph is optimised");
  app.add_positive("--resolution-m", s.map.resolution_m,
                   "cell size of the published map, with laser scans only");
  app.add_number("--threads", s.slam.threads, 1, 64,
                 "worker threads; more than one: loop search and particles run in parallel");
  app.add_file("--config", a.config, "JSON file of SLAM options; see submap_slam --print-config");
}

SE2d pose_of(const std::vector<double>& v) { return SE2d(v[0], v[1], Angle::degrees(v[2])); }

Result<void> complete(Arguments& a) {
  const bool filter = a.slam.sensors != SlamSensors::lidar;
  if (filter && (a.no_odometry || a.slam.imu || !a.config.empty()))
    return Error{ErrorCode::invalid,
                 "--no-odometry, --imu and --config are only for --sensors lidar"};
  a.slam.odometry = !a.no_odometry;
  a.slam.filter.threads = a.slam.slam.threads;
  a.slam.filter.particles = a.particles > 0                        ? a.particles
                            : a.slam.sensors == SlamSensors::radar ? 10
                                                                   : 30;
  if (a.laser.size() == 3)
    a.slam.T_base_laser = Transform2<frame::Base, frame::Laser>(pose_of(a.laser));
  if (a.radar.size() == 3)
    a.slam.T_base_radar = Transform2<frame::Base, frame::Radar>(pose_of(a.radar));
  if (a.config.empty()) return {};
  if (auto ok = examples::read_option_fields(a.config, examples::submap_slam_fields(a.slam.slam));
      !ok)
    return ok;
  return examples::check_grid(a.slam.slam.grid);
}

void run(ros::Node& node, const ros::SlamNodeOptions& options) {
  constexpr std::uint32_t kQueue = 2000;
  ros::SlamNode slam(options);
  auto map = node.latched_publisher<ros::OccupancyGrid>("map");
  auto path = node.latched_publisher<ros::Path>("path");
  auto poses = node.publisher<ros::PoseStamped>("pose");
  auto transforms = node.publisher<ros::TfMessage>("/tf");
  const auto publish = [&](const ros::SlamNodeOutput& out) {
    if (!out.transforms.empty()) transforms.publish({out.transforms});
    for (const ros::PoseStamped& pose : out.poses) poses.publish(pose);
    if (out.path) path.publish(*out.path);
    if (out.map) map.publish(*out.map);
    examples::say_all(node, out.notices);
  };
  bool clock_checked = false;
  node.subscribe<ros::TfMessage>("/tf_static", kQueue, [&](const auto& m) { slam.add(m); });
  node.subscribe<ros::TfMessage>("/tf", kQueue, [&](const auto& m) { slam.add(m); });
  if (options.odometry)
    node.subscribe<ros::Odometry>("odom", kQueue, [&](const auto& m) { slam.add(m, steady_s()); });
  if (options.imu)
    node.subscribe<ros::Imu>("imu", kQueue, [&](const auto& m) { slam.add(m, steady_s()); });
  const auto take = [&](const auto& m) {
    if (!std::exchange(clock_checked, true)) examples::check_clock(node, m.header);
    slam.add(m, steady_s());
  };
  if (options.sensors != SlamSensors::radar) node.subscribe<ros::LaserScan>("scan", kQueue, take);
  if (options.sensors != SlamSensors::lidar) {
    node.subscribe<ros::RadarScan>("radar", kQueue, take);
    node.subscribe<ros::PointCloud2>("radar_points", kQueue, take);
  }
  while (node.ok()) {
    node.spin(slam.busy() ? 0.0 : 0.05);
    publish(slam.work(steady_s()));
  }
}

}  // namespace

int main(int argc, char** argv) {
  Arguments arguments;
  examples::CommandLine app(
      "Submap SLAM with laser scans, or the particle filter with radar or both, as a ROS 1 node. "
      "Subscribes to sensor_msgs/LaserScan on 'scan', wayfare_msgs/RadarScan on 'radar' or "
      "sensor_msgs/PointCloud2 on 'radar_points', whichever arrives first, nav_msgs/Odometry on "
      "'odom' or, with laser scans only, sensor_msgs/Imu on 'imu', and transforms; publishes "
      "nav_msgs/OccupancyGrid on 'map' and nav_msgs/Path on 'path' (both latched), "
      "geometry_msgs/PoseStamped on 'pose' and the transform from map to odom (REP-105).");
  add_options(app, arguments);
  app.example("", "submap SLAM on the topics scan and odom");
  app.example("--no-odometry --imu scan:=front/scan", "without wheels, with an inertial unit");
  const auto started = examples::start_node(argc, argv, "slam_node", app);
  if (!started.node) return started.exit_code;
  if (const auto ok = complete(arguments); !ok) {
    started.node->say(ros::Severity::error, ok.error().to_string());
    return 1;
  }
  run(*started.node, arguments.slam);
  return 0;
}
