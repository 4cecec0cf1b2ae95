// Submap SLAM as a ROS 1 node.

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/ros/slam_node.hpp>

#include "node_program.hpp"
#include "submap_slam_fields.hpp"

namespace {

using namespace wayfare;
using examples::steady_s;

struct Arguments {
  ros::SlamNodeOptions slam;
  bool no_odometry = false;
  std::vector<double> laser;  ///< x, y in m, heading in degrees
  std::string config;
};

void add_options(examples::CommandLine& app, Arguments& a) {
  auto& s = a.slam;
  app.add_option("--map-frame", s.map_frame, "of map, pose and path").show_default();
  app.add_option("--odom-frame", s.odom_frame, "of the odometry").show_default();
  app.add_option("--base-frame", s.base_frame, "of the robot").show_default();
  app.add_option("--laser", a.laser,
                 "where the laser is on the robot: x and y in metres, heading in degrees; else the "
                 "transforms say")
      .expected(3);
  app.add_flag("--no-odometry", a.no_odometry,
               "do not wait for odometry; odom -> base is published by the node");
  app.add_flag("--imu", s.imu, "with --no-odometry: turns come from the inertial unit");
  app.add_option("--map-period-s", s.map_period_s, "between maps while scans come")
      .positive()
      .show_default();
  app.add_option("--patience-s", s.patience_s, "how long a scan waits for odometry of its time")
      .not_negative()
      .show_default();
  app.add_option("--settle-s", s.settle_s, "without scans, after which the graph is optimised")
      .positive()
      .show_default();
  app.add_option("--resolution-m", s.map.resolution_m, "side of the published map's cells")
      .positive()
      .show_default();
  app.add_option("--threads", s.slam.threads, "more than one: loops are searched beside")
      .range(1, 64)
      .show_default();
  app.add_option("--config", a.config,
                 "JSON file of options of SLAM; see submap_slam's "
                 "--print-config")
      .existing_file();
}

Result<void> complete(Arguments& a) {
  a.slam.odometry = !a.no_odometry;
  if (a.laser.size() == 3)
    a.slam.T_base_laser = Transform2<frame::Base, frame::Laser>(
        SE2d(a.laser[0], a.laser[1], Angle::degrees(a.laser[2])));
  if (a.config.empty()) return {};
  if (auto ok = examples::read_option_fields(a.config, examples::submap_slam_fields(a.slam.slam));
      !ok)
    return ok;
  return examples::check_submap_slam(a.slam.slam);
}

/// Topics out.
class Outlet {
 public:
  explicit Outlet(ros::Node& node)
      : node_(node),
        map_(node.latched_publisher<ros::OccupancyGrid>("map")),
        path_(node.latched_publisher<ros::Path>("path")),
        pose_(node.publisher<ros::PoseStamped>("pose")),
        tf_(node.publisher<ros::TfMessage>("/tf")) {}

  void give(const ros::SlamNodeOutput& out) {
    if (!out.transforms.empty()) tf_.publish({out.transforms});
    for (const ros::PoseStamped& pose : out.poses) pose_.publish(pose);
    if (out.path) path_.publish(*out.path);
    if (out.map) map_.publish(*out.map);
    examples::say_all(node_, out.notices);
  }

 private:
  ros::Node& node_;
  ros::Publisher<ros::OccupancyGrid> map_;
  ros::Publisher<ros::Path> path_;
  ros::Publisher<ros::PoseStamped> pose_;
  ros::Publisher<ros::TfMessage> tf_;
};

void run(ros::Node& node, const ros::SlamNodeOptions& options) {
  constexpr std::uint32_t kQueue = 2000;
  ros::SlamNode slam(options);
  Outlet outlet(node);
  bool clock_checked = false;
  node.subscribe<ros::TfMessage>("/tf_static", kQueue, [&](const auto& m) { slam.add(m); });
  node.subscribe<ros::TfMessage>("/tf", kQueue, [&](const auto& m) { slam.add(m); });
  if (options.odometry)
    node.subscribe<ros::Odometry>("odom", kQueue, [&](const auto& m) { slam.add(m, steady_s()); });
  if (options.imu)
    node.subscribe<ros::Imu>("imu", kQueue, [&](const auto& m) { slam.add(m, steady_s()); });
  node.subscribe<ros::LaserScan>("scan", kQueue, [&](const ros::LaserScan& m) {
    if (!std::exchange(clock_checked, true)) examples::check_clock(node, m.header);
    slam.add(m, steady_s());
  });
  while (node.ok()) {
    node.spin(slam.busy() ? 0.0 : 0.05);
    outlet.give(slam.work(steady_s()));
  }
}

}  // namespace

int main(int argc, char** argv) {
  Arguments arguments;
  examples::CommandLine app(
      "Map by submap SLAM as a ROS 1 node. Takes sensor_msgs/LaserScan on 'scan', "
      "nav_msgs/Odometry on 'odom' or sensor_msgs/Imu on 'imu', and transforms; gives "
      "nav_msgs/OccupancyGrid on 'map' and nav_msgs/Path on 'path' (both latched), "
      "geometry_msgs/PoseStamped on 'pose' and the transform from map to odom (REP-105).");
  add_options(app, arguments);
  const auto started = examples::start_node(argc, argv, "slam_node", app);
  if (!started.node) return started.exit_code;
  if (const auto ok = complete(arguments); !ok) {
    started.node->say(ros::Severity::error, ok.error().to_string());
    return 1;
  }
  run(*started.node, arguments.slam);
  return 0;
}
