#include "slam_node_program.hpp"

#include <cmath>
#include <optional>
#include <utility>

namespace wayfare::examples {
namespace {

void run(ros::Node& node, const ros::SlamNodeOptions& options) {
  const ros::Qos queue = ros::Qos::queue(2000);
  ros::SlamNode slam(options);
  auto map = node.publisher<ros::OccupancyGrid>("map", ros::Qos::latched());
  auto path = node.publisher<ros::Path>("path", ros::Qos::latched());
  auto poses = node.publisher<ros::PoseWithCovarianceStamped>("pose");
  std::optional<ros::Publisher<ros::PoseArray>> particles;
  if (options.sensors != SlamSensors::lidar)
    particles = node.publisher<ros::PoseArray>("particle_cloud", ros::Qos::sensor_data());
  auto transforms = node.publisher<ros::TfMessage>("/tf");
  const auto publish = [&](const ros::SlamNodeOutput& out) {
    if (!out.transforms.empty()) transforms.publish({out.transforms});
    for (const auto& pose : out.poses) poses.publish(pose);
    if (out.particles) particles->publish(*out.particles);
    if (out.path) path.publish(*out.path);
    if (out.map) map.publish(*out.map);
    say_all(node, out.notices);
  };
  bool clock_checked = false;
  subscribe_to_transforms(node, [&](const auto& m) { slam.add(m); });
  if (options.odometry)
    node.subscribe<ros::Odometry>("odom", queue, [&](const auto& m) { slam.add(m, steady_s()); });
  if (options.imu)
    node.subscribe<ros::Imu>("imu", queue, [&](const auto& m) { slam.add(m, steady_s()); });
  if (options.magnetometer)
    node.subscribe<ros::MagneticField>("magnetic_field", queue,
                                       [&](const auto& m) { slam.add(m, steady_s()); });
  const auto take = [&](const auto& m) {
    if (!std::exchange(clock_checked, true)) check_clock(node, m.header);
    slam.add(m, steady_s());
  };
  if (options.sensors != SlamSensors::radar) node.subscribe<ros::LaserScan>("scan", queue, take);
  if (options.sensors != SlamSensors::lidar) {
    node.subscribe<ros::RadarScan>("radar", queue, take);
    node.subscribe<ros::PointCloud2>("radar_points", queue, take);
  }
  process_scans(node, slam, publish);
}

}  // namespace

void add_scan_options(CommandLine& app, ros::ScanNodeOptions& s, std::vector<double>& laser) {
  app.add_option("--map-frame", s.map_frame, "of map and poses").show_default();
  app.add_option("--odom-frame", s.odom_frame, "of the odometry").show_default();
  app.add_option("--base-frame", s.base_frame, "of the robot").show_default();
  app.add_option(
         "--laser", laser,
         "pose of the laser on the robot: x and y in metres, heading in degrees; by default "
         "from the transforms")
      .expected(3);
  app.add_option("--patience-s", s.patience_s,
                 "longest time a scan waits for odometry or inertial samples")
      .not_negative()
      .show_default();
}

void add_slam_options(CommandLine& app, SlamNodeArguments& a, const std::string& program) {
  auto& s = a.node;
  add_scan_options(app, s, a.laser);
  app.add_positive("--map-period-s", s.map_period_s, "interval between maps");
  app.add_positive("--settle-s", s.settle_s,
                   "time without scans after which the graph is optimised");
  app.add_file("--config", a.config,
               "JSON file of SLAM options; see " + program + " --print-config");
}

void add_unit_options(CommandLine& app, SlamNodeArguments& a) {
  app.add_option("--forward", a.forward,
                 "the inertial unit's axis along which the laser's x points, its z upward; by "
                 "default from the transforms")
      .one_of({"x", "y", "-x", "-y"});
}

void add_threads(CommandLine& app, SlamNodeArguments& a) {
  app.add_number("--threads", a.node.slam.threads, 1, 64,
                 "worker threads; more than one: loop search and particles run in parallel");
}

void add_resolution(CommandLine& app, SlamNodeArguments& a) {
  app.add_positive("--resolution-m", a.node.map.resolution_m,
                   "cell size of the published map, with laser scans only");
}

void subscribe_to_transforms(ros::Node& node,
                             const std::function<void(const ros::TfMessage&)>& take) {
  node.subscribe<ros::TfMessage>("/tf_static", ros::Qos::latched(2000), take);
  node.subscribe<ros::TfMessage>("/tf", ros::Qos::queue(2000), take);
}

void say_counts(const ros::Node& node, const ros::ScanNode& scans) {
  say_counts(node);
  for (const auto& [what, number] : scans.left_out())
    node.say(ros::Severity::warning, "left out in all: " + std::to_string(number) + " of " + what);
}

SE2d pose_of(const std::vector<double>& v) { return SE2d(v[0], v[1], Angle::degrees(v[2])); }

Result<void> complete(SlamNodeArguments& a, const std::vector<OptionField>& fields,
                      const MultiResolutionOptions& grid) {
  if (a.laser.size() == 3)
    a.node.T_base_laser = Transform2<frame::Base, frame::Laser>(pose_of(a.laser));
  if (!a.forward.empty())
    a.node.unit_forward =
        (a.forward[0] == '-' ? -1.0 : 1.0) * Eigen::Vector3d::Unit(a.forward.back() - 'x');
  if (a.config.empty()) return {};
  if (auto ok = read_option_fields(a.config, fields); !ok) return ok;
  return check_grid(grid);
}

int run_slam_node(int argc, char** argv, const std::string& name, CommandLine& app,
                  const ros::SlamNodeOptions& options,
                  const std::function<Result<void>()>& complete) {
  const auto started = start_node(argc, argv, name, app);
  if (!started.node) return started.exit_code;
  if (const auto ok = complete(); !ok) {
    started.node->say(ros::Severity::error, ok.error().to_string());
    return 1;
  }
  run(*started.node, options);
  return 0;
}

}  // namespace wayfare::examples
