// SLAM as a process, live against offline.

#include <signal.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include <wayfare/io/carmen.hpp>
#include <wayfare/io/map_image.hpp>
#include <wayfare/ros/convert.hpp>
#include <wayfare/ros/recording.hpp>
#include <wayfare/slam/radar_slam.hpp>
#include <wayfare/slam/submap_slam.hpp>
#include "live.hpp"
#include "room_drive.hpp"

namespace wayfare {
namespace {

using ::testing::HasSubstr;
using testing::Process;
using testing::room_drive;

using testing::Command;
using testing::Live;

Process slam_node(const std::string& patience_s,
                  const Command& options = {"--map-period-s", "0.5"}) {
  Command command = {WAYFARE_SLAM_NODE, "--patience-s", patience_s, "--settle-s", "1.5"};
  command.insert(command.end(), options.begin(), options.end());
  return Process(Live::in_its_own_topics(command), Live::path("slam_node.txt"));
}
std::string bag_of(const Recording& recording, const std::string& name) {
  auto writer = ros::RecordingWriter::create(Live::path(name));
  EXPECT_TRUE(writer) << name;
  const auto written = ros::write_robot(*writer, recording);
  EXPECT_TRUE(written) << written.error().to_string();
  EXPECT_TRUE(writer->close()) << name;
  return Live::path(name);
}
Process play_room(const Command& options) {
  static const std::string room = bag_of(room_drive(), "room.bag");
  return Live::play(room, {"/scan", "/odom"}, options);
}

/// Whether every occupied cell of `a` has one of `b` within a distance of one cell.
bool has_all(const ros::OccupancyGrid& a, const ros::OccupancyGrid& b) {
  constexpr int kOccupied = 65;
  const auto cells = [&](double a_m, double b_m) {
    return static_cast<int>(std::lround((a_m - b_m) / static_cast<double>(a.info.resolution)));
  };
  const int dx = cells(a.info.origin.position.x, b.info.origin.position.x);
  const int dy = cells(a.info.origin.position.y, b.info.origin.position.y);
  const int width = static_cast<int>(b.info.width), height = static_cast<int>(b.info.height);
  const auto near = [&](int x, int y) {
    for (int v = std::max(0, y - 1); v <= std::min(height - 1, y + 1); ++v)
      for (int u = std::max(0, x - 1); u <= std::min(width - 1, x + 1); ++u)
        if (b.data[static_cast<std::size_t>(v * width + u)] >= kOccupied) return true;
    return false;
  };
  for (std::size_t i = 0; i < a.data.size(); ++i)
    if (a.data[i] >= kOccupied &&
        !near(static_cast<int>(i % a.info.width) + dx, static_cast<int>(i / a.info.width) + dy))
      return false;
  return true;
}

bool same_within_a_cell(const ros::OccupancyGrid& a, const ros::OccupancyGrid& b) {
  return has_all(a, b) && has_all(b, a);
}

ros::OccupancyGrid made_offline(const Recording& r) {
  return ros::message_of(io::grid_image(run_submap_slam(r)->map), r.scans.back().time, "map");
}
const ros::OccupancyGrid& offline_map() {
  static const ros::OccupancyGrid map = made_offline(room_drive());
  return map;
}

TEST_F(Live, ABagAtTwentyTimesItsSpeedGivesTheOfflineMap) {
  Process slam = slam_node("20");
  ASSERT_EQ(play_room({}).wait(120.0), 0) << slam.output();
  // No subscriber so far: the map is latched for later ones.
  spin_until(3.0, [] { return false; });
  const auto maps = listen<ros::OccupancyGrid>("map", ros::Qos::latched());
  const auto paths = listen<ros::Path>("path", ros::Qos::latched());
  const auto is_there = [&] {
    return !maps->empty() && same_within_a_cell(maps->back(), offline_map()) && !paths->empty();
  };
  ASSERT_TRUE(spin_until(30.0, is_there)) << maps->size() << " maps\n" << slam.output();
  EXPECT_EQ(paths->back().poses.size(), room_drive().scans.size());
  EXPECT_EQ(maps->back().header.stamp, offline_map().header.stamp);
  EXPECT_EQ(slam.end(SIGTERM), 0) << slam.output();
}

/// The Intel log until `seconds` after its first scan, live and offline.
void replay_intel(double seconds, const std::string& map_period_s) {
  WAYFARE_NEEDS_RECORDING(log, "slam2d/intel.clf.gz");
  auto intel = io::read_carmen(log);
  ASSERT_TRUE(intel);
  Recording& r = intel->recording;
  const LogTime end = r.scans.front().time + from_seconds(seconds);
  const auto later = [&](const auto& item) { return item.time > end; };
  std::erase_if(r.scans, later);
  std::erase_if(r.odometry, later);
  const auto offline = made_offline(r);
  Process slam = slam_node("20", {"--map-period-s", map_period_s});
  const auto maps = Live::listen<ros::OccupancyGrid>("map");
  const auto paths = Live::listen<ros::Path>("path");
  const auto begin = std::chrono::steady_clock::now();
  auto player =
      Live::play(bag_of(r, std::to_string(r.scans.size()) + " of intel.bag"), {"/scan", "/odom"});
  // Process what is received meanwhile: a queue has a capacity of a thousand.
  int code = -1;
  const double lasts_s = to_seconds(r.scans.back().time - r.scans.front().time);
  Live::spin_until(60.0 + lasts_s / 10.0, [&] { return (code = player.wait(0.0)) != -1; });
  ASSERT_EQ(code, 0) << slam.output();
  const auto same = [&] {
    return !maps->empty() && same_within_a_cell(maps->back(), offline) && !paths->empty() &&
           paths->back().poses.size() == r.scans.size();
  };
  ASSERT_TRUE(Live::spin_until(30.0, same)) << slam.output();
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  std::printf("%.0f s in %.1f s: %zu scans, %zu cells, the same to the bit: %s\n", lasts_s,
              took.count(), r.scans.size(), offline.data.size(),
              maps->back().data == offline.data ? "yes" : "no");
  EXPECT_EQ(slam.end(SIGTERM), 0);
}

TEST_F(Live, ARealLogAtTwentyTimesItsSpeedGivesTheOfflineMap) { replay_intel(400.0, "0.5"); }

// Takes minutes: enabled on request.
TEST_F(Live, DISABLED_AWholeRealLogGivesTheOfflineMap) { replay_intel(1e6, "5"); }

TEST_F(Live, RadarGivesTheOfflineMap) {
  const Recording& drive = testing::radar_drive();
  RadarSlamOptions few;
  few.particles = 4;
  const auto run = run_radar_slam(drive, few, SlamSensors::both);
  ASSERT_TRUE(run);
  const auto offline =
      ros::message_of(io::grid_image(run->map()), run->trajectory.back().time, "map");
  Process slam = slam_node("20", {"--sensors", "both", "--particles", "4"});
  const auto maps = listen<ros::OccupancyGrid>("map");
  const auto paths = listen<ros::Path>("path");
  ASSERT_EQ(play(bag_of(drive, "radar.bag"), {"/scan", "/odom", "/radar"}).wait(120.0), 0);
  EXPECT_TRUE(spin_until(30.0, [&] {
    return !maps->empty() && maps->back().data == offline.data && !paths->empty() &&
           paths->back().poses.size() == run->trajectory.size();
  })) << slam.output();
  EXPECT_EQ(slam.end(SIGTERM), 0);
}

TEST_F(Live, SurvivesARestartedPublisherAndTimeGoingBack) {
  Process slam = slam_node("20");
  const auto maps = listen<ros::OccupancyGrid>("map");
  const auto transforms = listen<ros::TfMessage>("tf");
  ASSERT_EQ(play_room({"--seconds", "15"}).wait(120.0), 0) << slam.output();
  ASSERT_EQ(play_room({"--from-s", "15"}).wait(120.0), 0) << slam.output();
  ASSERT_TRUE(spin_until(30.0, [&] {
    return !maps->empty() && same_within_a_cell(maps->back(), offline_map());
  })) << slam.output();
  ASSERT_EQ(play_room({"--seconds", "15"}).wait(120.0), 0) << slam.output();
  ASSERT_TRUE(spin_until(30.0, [&] {
    return maps->back().header.stamp.sec < offline_map().header.stamp.sec;
  })) << slam.output();
  EXPECT_THAT(slam.output(), HasSubstr("time went back by"));
  const auto from_map = [](const ros::TfMessage& m) {
    return m.transforms.front().header.frame_id == "map";
  };
  EXPECT_GT(std::count_if(transforms->begin(), transforms->end(), from_map), 100);
  EXPECT_EQ(slam.end(SIGTERM), 0);
}

TEST_F(Live, ReportsAMissingTransformAndContinuesOnceItIsThere) {
  Process slam = slam_node("1");
  const auto poses = listen<ros::PoseWithCovarianceStamped>("pose");
  EXPECT_TRUE(spin_until(30.0, [&] {
    return slam.output().find("waits for laser scans") != std::string::npos;
  })) << slam.output();
  ASSERT_EQ(
      play_room({"--seconds", "5", "--leave-out", "/tf_static", "--leave-out", "/tf"}).wait(120.0),
      0);
  EXPECT_TRUE(spin_until(30.0, [&] {
    return slam.output().find("waits for the transform from 'base_link' to 'laser'") !=
           std::string::npos;
  })) << slam.output();
  EXPECT_TRUE(poses->empty());
  auto transform = node_->publisher<ros::TfMessage>(topic("tf_static"), ros::Qos::latched());
  transform.publish(testing::mounting(room_drive()));
  EXPECT_TRUE(spin_until(30.0, [&] { return poses->size() >= 20; })) << slam.output();
  EXPECT_EQ(slam.end(SIGINT), 0);
}

}  // namespace
}  // namespace wayfare
