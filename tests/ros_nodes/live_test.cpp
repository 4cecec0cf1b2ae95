// Nodes as processes of their own, with a master of the test's own on the loopback address.

#include <signal.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include <wayfare/io/carmen.hpp>
#include <wayfare/io/grid_image.hpp>
#include <wayfare/ros/convert.hpp>
#include <wayfare/ros/recording_writer.hpp>
#include <wayfare/system/submap_slam.hpp>
#include "ros_nodes/live.hpp"
#include "ros_nodes/room_drive.hpp"

namespace wayfare {
namespace {

using ::testing::HasSubstr;
using testing::Process;
using testing::room_drive;

using testing::Command;
using testing::Live;

Process slam_node(const std::string& patience_s) {
  const Command command = {WAYFARE_SLAM_NODE, "--patience-s", patience_s,
                           "--map-period-s",  "0.5",          "_settle_s:=1.5"};
  return Process(Live::in_its_own_topics(command), Live::path("slam_node.txt"));
}
std::string bag_of(const Recording& recording, const std::string& name) {
  auto writer = ros::RecordingWriter::create(Live::path(name));
  EXPECT_TRUE(writer && ros::write_robot(*writer, recording) && writer->close());
  return Live::path(name);
}
/// A bag, twenty times as fast as it was.
Process play_bag(const std::string& bag, const Command& options) {
  Command command = {WAYFARE_PLAY_RECORDING, bag,     "--speed",       "20", "--wait-for", "/scan",
                     "--wait-for",           "/odom", "__name:=player"};
  command.insert(command.end(), options.begin(), options.end());
  return Process(Live::in_its_own_topics(command), Live::path("player.txt"));
}
Process play(const Command& options) {
  static const std::string room = bag_of(room_drive(), "room.bag");
  return play_bag(room, options);
}

/// Whether every occupied cell of `a` has one of `b` within a cell of it.
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

TEST_F(Live, ABagAtTwentyTimesItsSpeedMakesTheMapThatIsMadeOffline) {
  Process slam = slam_node("20");
  ASSERT_EQ(play({}).wait(120.0), 0) << slam.output();
  // Nobody listened so far: the map is there for who comes late.
  spin_until(3.0, [] { return false; });
  const auto maps = listen<ros::OccupancyGrid>("map");
  const auto paths = listen<ros::Path>("path");
  const auto is_there = [&] {
    return !maps->empty() && same_within_a_cell(maps->back(), offline_map()) && !paths->empty();
  };
  ASSERT_TRUE(spin_until(30.0, is_there)) << maps->size() << " maps\n" << slam.output();
  EXPECT_EQ(paths->back().poses.size(), room_drive().scans.size());
  EXPECT_EQ(maps->back().header.stamp, offline_map().header.stamp);
  EXPECT_EQ(slam.end(SIGTERM), 0) << slam.output();
}

TEST_F(Live, ARealLogAtTwentyTimesItsSpeedMakesTheMapThatIsMadeOffline) {
  WAYFARE_NEEDS_RECORDING(log, "slam2d/intel.clf.gz");
  auto intel = io::read_carmen(log);
  ASSERT_TRUE(intel);
  Recording& r = intel->recording;
  const LogTime end = r.scans.front().time + from_seconds(400.0);
  const auto later = [&](const auto& item) { return item.time > end; };
  std::erase_if(r.scans, later);
  std::erase_if(r.odometry, later);
  const auto offline = made_offline(r);
  Process slam = slam_node("20");
  const auto maps = listen<ros::OccupancyGrid>("map");
  const auto poses = listen<ros::PoseStamped>("pose");
  ASSERT_EQ(play_bag(bag_of(r, "intel.bag"), {}).wait(120.0), 0) << slam.output();
  ASSERT_TRUE(spin_until(30.0, [&] {
    return !maps->empty() && same_within_a_cell(maps->back(), offline);
  })) << slam.output();
  EXPECT_EQ(poses->size(), r.scans.size());
  std::printf("%zu scans, %zu cells, the same to the bit: %s\n", poses->size(), offline.data.size(),
              maps->back().data == offline.data ? "yes" : "no");
  EXPECT_EQ(slam.end(SIGTERM), 0);
}

TEST_F(Live, SurvivesARestartedPublisherAndTimeGoingBack) {
  Process slam = slam_node("20");
  const auto maps = listen<ros::OccupancyGrid>("map");
  const auto transforms = listen<ros::TfMessage>("tf");
  ASSERT_EQ(play({"--seconds", "15"}).wait(120.0), 0) << slam.output();
  ASSERT_EQ(play({"--from-s", "15"}).wait(120.0), 0) << slam.output();
  ASSERT_TRUE(spin_until(30.0, [&] {
    return !maps->empty() && same_within_a_cell(maps->back(), offline_map());
  })) << slam.output();
  ASSERT_EQ(play({"--seconds", "15"}).wait(120.0), 0) << slam.output();
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

TEST_F(Live, SaysThatItWaitsForATransformAndGoesOnOnceItIsThere) {
  Process slam = slam_node("1");
  const auto poses = listen<ros::PoseStamped>("pose");
  EXPECT_TRUE(spin_until(30.0, [&] {
    return slam.output().find("waits for laser scans") != std::string::npos;
  })) << slam.output();
  ASSERT_EQ(play({"--seconds", "5", "--leave-out", "/tf_static", "--leave-out", "/tf"}).wait(120.0),
            0);
  EXPECT_TRUE(spin_until(30.0, [&] {
    return slam.output().find("waits for the transform from 'base_link' to 'laser'") !=
           std::string::npos;
  })) << slam.output();
  EXPECT_TRUE(poses->empty());
  auto transform = node_->latched_publisher<ros::TfMessage>(topic("tf_static"));
  transform.publish(testing::mounting(room_drive()));
  EXPECT_TRUE(spin_until(30.0, [&] { return poses->size() >= 20; })) << slam.output();
  EXPECT_EQ(slam.end(SIGINT), 0);
}

}  // namespace
}  // namespace wayfare
