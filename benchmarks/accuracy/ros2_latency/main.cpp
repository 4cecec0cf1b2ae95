// Latency of a SLAM node of ROS 2 from scan to pose, samples lost, and its memory over time.

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <numbers>
#include <string>
#include <thread>
#include <vector>

#include <wayfare/io/map_image.hpp>
#include <wayfare/ros/convert.hpp>
#include <wayfare/ros/node.hpp>
#include <wayfare/ros/ros2_node.hpp>
#include <wayfare/sim/floor_plan.hpp>

#include "support/command_line.hpp"

namespace {

using namespace wayfare;
using Clock = std::chrono::steady_clock;

constexpr double kRate_hz = 40.0;
constexpr std::size_t kBeams = 1080;
constexpr std::size_t kLap = 1600;  ///< scans of a lap: 40 s

struct Arguments {
  std::string node, config;
  bool localise = false;
  double minutes = 1.0;
};

/// A hall with pillars, and laps through it.
class Laps {
 public:
  Laps()
      : plan_(sim::read_plan("metres_per_character 1\npicture\n"
                             "####################\n#                  #\n"
                             "#  ##           #  #\n#                  #\n"
                             "#       ##     ##  #\n#                  #\n"
                             "#   #              #\n#              ##  #\n"
                             "#                  #\n####################\n")
                  ->plan) {
    sim::Lidar2dParams lidar;
    lidar.beams = kBeams;
    lidar.first_bearing = Angle::degrees(-135.0);
    lidar.bearing_step = Angle::degrees(0.25);
    Rng rng(1);
    for (std::size_t i = 0; i < kLap; ++i)
      scans_.push_back(sim::simulate_scan(
          plan_, [&](LogTime) { return pose(i); }, LogTime(), lidar, rng));
  }
  /// For a localising node.
  [[nodiscard]] ros::OccupancyGrid map() const {
    const auto grid = sim::map_of_plan(plan_, Eigen::Vector2d(10.5, 4.5));
    return ros::message_of(io::grid_image(*grid), LogTime::from_seconds(1.0), "map");
  }
  [[nodiscard]] LaserScan scan(std::size_t i) const { return scans_[i % kLap]; }
  /// A circle of 3 m radius around the middle.
  [[nodiscard]] static SE2d pose(std::size_t i) {
    const double angle = 2.0 * std::numbers::pi * static_cast<double>(i % kLap) / kLap;
    return {10.0 + 3.0 * std::cos(angle), 5.0 + 3.0 * std::sin(angle),
            Angle::radians(angle + std::numbers::pi / 2.0)};
  }

 private:
  sim::FloorPlan plan_;
  std::vector<LaserScan> scans_;
};

/// The node as a child process.
class Child {
 public:
  explicit Child(const std::vector<std::string>& command) {
    std::vector<char*> argv;
    for (const std::string& word : command) argv.push_back(const_cast<char*>(word.c_str()));
    argv.push_back(nullptr);
    pid_ = ::fork();
    if (pid_ == 0) {
      ::execv(argv[0], argv.data());
      ::_exit(127);
    }
  }
  ~Child() {
    ::kill(pid_, SIGTERM);
    ::waitpid(pid_, nullptr, 0);
  }
  [[nodiscard]] double resident_mb() const {
    std::ifstream status("/proc/" + std::to_string(pid_) + "/status");
    for (std::string line; std::getline(status, line);)
      if (line.starts_with("VmRSS:")) return std::stod(line.substr(6)) / 1024.0;
    return 0.0;
  }

 private:
  pid_t pid_ = -1;
};

void print_latencies(std::vector<double> ms) {
  if (ms.empty()) return;
  std::sort(ms.begin(), ms.end());
  const auto at = [&](double q) {
    return ms[static_cast<std::size_t>(q * static_cast<double>(ms.size() - 1))];
  };
  std::printf("scan to pose, ms: median %.2f, 99 %% %.2f, 99.9 %% %.2f, largest %.2f\n", at(0.5),
              at(0.99), at(0.999), ms.back());
  for (double low = 0.0, high = 1.0; low < ms.back(); low = high, high *= 2.0) {
    const auto n =
        std::lower_bound(ms.begin(), ms.end(), high) - std::lower_bound(ms.begin(), ms.end(), low);
    std::printf("%7.0f to %6.0f ms: %8td  %s\n", low, high, n,
                std::string(static_cast<std::size_t>(60 * n / std::ssize(ms)), '#').c_str());
  }
}

int run(const Arguments& a) {
  ::setenv("ROS_VERSION", "2", 1);
  ::setenv("ROS_DOMAIN_ID", std::to_string(::getpid() % 100 + 1).c_str(), 1);
  std::vector<std::string> command = {a.node, "--laser", "0", "0", "0"};
  if (!a.config.empty()) command.insert(command.end(), {"--config", a.config});
  if (a.localise)
    command.insert(command.end(),
                   {"--initial", "13", "5", "1.57", "--ros-args", "-r", "map:=map_of_plan"});
  std::vector<std::string> none = {"ros2_latency"};
  auto raw = ros::ros2_node(none, "ros2_latency");
  if (!raw) return std::fprintf(stderr, "%s\n", raw.error().to_string().c_str()), 1;
  ros::Node node(*std::move(raw));
  if (!node.raw().connect()) return 1;
  const Laps laps;
  const Child child(command);
  auto scans = node.publisher<ros::LaserScan>("scan", ros::Qos::queue(10));
  auto odometry = node.publisher<ros::Odometry>("odom", ros::Qos::queue(10));
  std::map<std::int64_t, Clock::time_point> sent;
  std::vector<double> latencies_ms;
  const auto take = [&](const auto& m) {
    const auto found = sent.find(ros::time_of(m.header.stamp)->nanoseconds());
    if (found == sent.end()) return;
    const std::chrono::duration<double, std::milli> took = Clock::now() - found->second;
    latencies_ms.push_back(took.count());
    sent.erase(sent.begin(), std::next(found));
  };
  node.subscribe<ros::PoseWithCovarianceStamped>("pose", ros::Qos::queue(1000), take);
  node.subscribe<ros::PoseWithCovarianceStamped>("amcl_pose", ros::Qos::queue(1000), take);
  auto map = node.publisher<ros::OccupancyGrid>("map_of_plan", ros::Qos::latched());
  map.publish(laps.map());
  while (node.ok() && (scans.subscribers() == 0 || odometry.subscribers() == 0)) node.spin(0.05);

  const auto begin = Clock::now();
  const LogTime start = LogTime::from_nanoseconds(node.now_ns());
  const auto end = static_cast<std::size_t>(a.minutes * 60.0 * kRate_hz);
  std::printf("minute  node, MB  poses of scans\n");
  std::size_t scans_sent = 0;
  for (std::size_t i = 0; i < end && node.ok(); ++i) {
    const auto since = from_seconds(static_cast<double>(i) / kRate_hz);
    while (node.ok() && Clock::now() < begin + since)
      node.spin(std::chrono::duration<double>(begin + since - Clock::now()).count());
    LaserScan scan = laps.scan(i);
    scan.time = start + since;
    const OdometrySample moved{scan.time, Transform2<frame::Odom, frame::Base>(Laps::pose(i))};
    odometry.publish(ros::message_of(moved, "odom", "base_link"));
    sent[scan.time.nanoseconds()] = Clock::now();
    scans.publish(ros::message_of(scan, "laser"));
    ++scans_sent;
    if ((i + 1) % static_cast<std::size_t>(60.0 * kRate_hz) == 0) {
      std::printf("%6.0f  %8.1f  %zu of %zu\n", static_cast<double>(i + 1) / kRate_hz / 60.0,
                  child.resident_mb(), latencies_ms.size(), i + 1);
      std::fflush(stdout);
    }
  }
  for (int i = 0; i < 40; ++i) node.spin(0.05);
  std::printf("%zu scans, %zu poses\n", scans_sent, latencies_ms.size());
  for (const ros::TopicCounts& c : node.counts())
    std::printf("%s: %llu received, %llu refused, %llu lost\n", c.topic.c_str(),
                static_cast<unsigned long long>(c.received),
                static_cast<unsigned long long>(c.refused),
                static_cast<unsigned long long>(c.lost));
  print_latencies(latencies_ms);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  Arguments a;
  examples::CommandLine app(
      "Measure a SLAM node of ROS 2: scans of 1080 beams at 40 Hz with odometry, of a simulated "
      "robot that drives laps, to a node in a process of its own. Prints the latency from a scan "
      "to "
      "its pose, lost samples, and the node's memory each minute.");
  app.add_file("NODE", a.node, "the program of the node, such as build/bin/slam_node").required();
  app.add_flag("--localise", a.localise, "the node localises: it gets the map and the first pose");
  app.add_file("--config", a.config, "JSON file of the node's options");
  app.add_positive("--minutes", a.minutes, "duration");
  app.example("--minutes 60 build/bin/slam_node", "an hour of submap SLAM");
  app.example("--minutes 60 --localise build/bin/localise_node",
              "localisation, which keeps no trajectory");
  if (const auto code = app.parse(argc, argv)) return *code;
  return run(a);
}
