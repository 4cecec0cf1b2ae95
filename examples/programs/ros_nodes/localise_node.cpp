// Monte-Carlo localisation on a known map as a node, with the interface of ROS's AMCL.

#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include <wayfare/io/map_image.hpp>
#include <wayfare/ros/localise_node.hpp>

#include "slam_node_program.hpp"

namespace {

using namespace wayfare;
using examples::steady_s;

struct Arguments {
  ros::LocaliseNodeOptions node;
  std::vector<double> laser;    ///< x, y in m, heading in degrees
  std::vector<double> initial;  ///< x, y in m, heading in radians
  std::string map;              ///< its .yaml file; empty: the topic
  bool by_transforms = false, beam = false;
};

void add_options(examples::CommandLine& app, Arguments& a) {
  app.add_file("--map-file", a.map, "the .yaml file of the map; by default the topic 'map'");
  app.add_option(
         "--initial", a.initial,
         "x, y and heading in the map, m and rad: the pose at the first scan, to within half "
         "a metre and 15 degrees; by default the topic 'initialpose'")
      .expected(3);
  app.add_flag("--global", a.node.global, "search the whole map");
  examples::add_scan_options(app, a.node, a.laser);
  app.add_flag("--odometry-by-tf", a.by_transforms,
               "odometry by the transforms from odom to base on /tf, not by the topic 'odom'");
  app.add_flag("--beam", a.beam, "the beam model instead of the likelihood field");
  app.add_number("--beams", a.node.localisation.beams, 4, 10000, "beams used per scan");
  app.add_positive("--max-range", a.node.localisation.max_range_m,
                   "farther returns are not used, m");
  app.add_number("--particles", a.node.localisation.max_particles, 100, 10000000,
                 "largest number of particles");
  app.add_positive("--sigma", a.node.map.lidar.sigma_m, "of a range, m");
  app.add_number("--seed", a.node.seed, 0, 1'000'000'000,
                 "of the random numbers: the same seed gives the same result");
  app.add_number("--threads", a.node.localisation.threads, 1, 64, "worker threads");
}

/// Sets what the options give; the map of the file, if there is one.
Result<std::optional<ros::OccupancyGrid>> complete(Arguments& a, LogTime now) {
  if (a.laser.size() == 3)
    a.node.T_base_laser = Transform2<frame::Base, frame::Laser>(examples::pose_of(a.laser));
  if (a.by_transforms) a.node.source = ros::OdometrySource::transforms;
  if (a.beam) a.node.localisation.model = ScanLikelihood::beam;
  if (a.initial.size() == 3) {
    const SE2d pose(a.initial[0], a.initial[1], Angle::radians(a.initial[2]));
    a.node.initial = Gaussian<SE2d>{pose, Eigen::Vector3d(0.25, 0.25, 0.07).asDiagonal()};
  }
  if (a.map.empty()) return std::optional<ros::OccupancyGrid>();
  const auto image = io::read_map(a.map);
  if (!image) return image.error();
  return std::optional(ros::message_of(*image, now, a.node.map_frame));
}

void run(ros::Node& node, const Arguments& a, const std::optional<ros::OccupancyGrid>& map) {
  const ros::Qos queue = ros::Qos::queue(2000);
  ros::LocaliseNode localiser(a.node);
  auto poses = node.publisher<ros::PoseWithCovarianceStamped>("amcl_pose", ros::Qos::latched());
  auto particles = node.publisher<ros::ParticleCloud>("particle_cloud", ros::Qos::sensor_data());
  auto transforms = node.publisher<ros::TfMessage>("/tf");
  const auto publish = [&](const ros::LocaliseNodeOutput& out) {
    if (!out.transforms.empty()) transforms.publish({out.transforms});
    for (const auto& pose : out.poses) poses.publish(pose);
    if (out.particles) particles.publish(*out.particles);
    examples::say_all(node, out.notices);
  };
  std::optional<ros::Publisher<ros::OccupancyGrid>> shown;
  if (map) {
    shown = node.publisher<ros::OccupancyGrid>("map", ros::Qos::latched());
    shown->publish(*map);
    localiser.add(*map, steady_s());
  } else {
    node.subscribe<ros::OccupancyGrid>("map", ros::Qos::latched(),
                                       [&](const auto& m) { localiser.add(m, steady_s()); });
  }
  examples::subscribe_to_transforms(node, [&](const auto& m) { localiser.add(m, steady_s()); });
  if (a.node.source == ros::OdometrySource::messages)
    node.subscribe<ros::Odometry>("odom", queue,
                                  [&](const auto& m) { localiser.add(m, steady_s()); });
  node.subscribe<ros::PoseWithCovarianceStamped>(
      "initialpose", ros::Qos::queue(10), [&](const auto& m) { localiser.add(m, steady_s()); });
  bool clock_checked = false;
  node.subscribe<ros::LaserScan>("scan", queue, [&](const auto& m) {
    if (!std::exchange(clock_checked, true)) examples::check_clock(node, m.header);
    localiser.add(m, steady_s());
  });
  examples::process_scans(node, localiser, publish);
}

}  // namespace

int main(int argc, char** argv) {
  Arguments a;
  examples::CommandLine app(
      "Monte-Carlo localisation on a known map as a ROS node, with the interface of AMCL. "
      "Subscribes "
      "to nav_msgs/OccupancyGrid on 'map', sensor_msgs/LaserScan on 'scan', nav_msgs/Odometry on "
      "'odom', geometry_msgs/PoseWithCovarianceStamped on 'initialpose', and transforms; publishes "
      "geometry_msgs/PoseWithCovarianceStamped on 'amcl_pose', nav2_msgs/ParticleCloud on "
      "'particle_cloud' and the transform from map to odom (REP-105).");
  add_options(app, a);
  app.example("--map-file office.yaml", "waits for a pose, as from RViz");
  app.example("--global", "on the map of the topic, by a search of all of it");
  const auto started = examples::start_node(argc, argv, "localise_node", app);
  if (!started.node) return started.exit_code;
  const auto map = complete(a, LogTime::from_nanoseconds(started.node->now_ns()));
  if (!map) {
    started.node->say(ros::Severity::error, map.error().to_string());
    return 1;
  }
  run(*started.node, a, *map);
  return 0;
}
