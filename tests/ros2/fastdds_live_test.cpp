// Programs on Fast DDS around the SLAM node: they play the robot's messages and record the map.

#include <signal.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/io/carmen.hpp>
#include <wayfare/io/map_image.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/ros/recording.hpp>
#include <wayfare/slam/submap_slam.hpp>
#include "ros/nodes/live.hpp"
#include "ros/nodes/room_drive.hpp"
#include "ros2/peer/records.hpp"

namespace wayfare {
namespace {

using testing::Command;
using ::testing::HasSubstr;
using testing::Live;
using testing::Process;

/// A writer knows of a reader before the reader knows of it; what it sends meanwhile is lost to a
/// volatile reader. So the peer's first message, a transform, is this long before the others.
constexpr double kMeanwhile_s = 2.0;
constexpr double kSpeed = 20.0;

/// The messages of a drive as the peer plays them, on the topics of the test.
void write_for_peer(const std::string& mcap, const std::string& to) {
  const auto file = ros::RecordingFile::open(mcap);
  ASSERT_TRUE(file);
  std::ofstream records(to, std::ios::binary);
  const auto write = [&](const ros::RecordedMessage& m) {
    const bool is_first = records.tellp() == 0;
    const LogTime at = m.received + from_seconds(is_first ? 0.0 : kMeanwhile_s * kSpeed);
    peer::write_record(records, {at.nanoseconds(), "rt" + Live::topic(m.topic.name.substr(1)),
                                 ros::ros2_name(m.topic.type), std::string(m.data)});
    return true;
  };
  EXPECT_TRUE(file->read({"/scan", "/odom", "/tf_static"}, write).empty());
}

/// A drive played by the peer into the node, whose map the peer records, against the offline map.
void drive_on_fastdds(const Recording& drive, const std::string& map_period_s) {
  const std::string log = Live::path(std::to_string(drive.scans.size()) + " scans.mcap");
  auto mcap = ros::RecordingWriter::create(log);
  ASSERT_TRUE(mcap);
  ASSERT_TRUE(ros::write_robot(*mcap, drive));
  ASSERT_TRUE(mcap->close());
  write_for_peer(log, Live::path("robot.records"));
  const auto offline =
      ros::message_of(io::grid_image(run_submap_slam(drive)->map), drive.scans.back().time, "map");
  Process slam(Live::in_its_own_topics({WAYFARE_SLAM_NODE, "--patience-s", "20", "--settle-s",
                                        "1.5", "--map-period-s", map_period_s}),
               Live::path("slam_of_peer.txt"));
  Process robot({WAYFARE_FASTDDS_PEER, "play", Live::path("robot.records"), "--speed",
                 std::to_string(kSpeed), "--wait-for", "1", "--transient-local", "--depth", "2000"},
                Live::path("robot.txt"));
  const double lasts_s = to_seconds(drive.scans.back().time - drive.scans.front().time);
  ASSERT_EQ(robot.wait(60.0 + lasts_s / 10.0), 0) << robot.output() << slam.output();
  // Each of the peer's readers is late: it gets the last map. The one at the end is optimised.
  const auto is_there = [&] {
    const std::string records = Live::path("map.records");
    Process rviz({WAYFARE_FASTDDS_PEER, "record", "rt" + Live::topic("map"),
                  "nav_msgs/msg/OccupancyGrid", "1", records, "--transient-local", "--depth", "1"},
                 Live::path("rviz.txt"));
    if (rviz.wait(30.0) != 0) return false;
    const auto map = ros::from_cdr<ros::OccupancyGrid>(peer::read_records(records).at(0).bytes);
    return map && map->data == offline.data && map->header.stamp == offline.header.stamp;
  };
  EXPECT_TRUE(Live::spin_until(60.0, is_there)) << slam.output();
  EXPECT_EQ(slam.end(SIGTERM), 0) << slam.output();
  EXPECT_EQ(slam.output().find("lost"), std::string::npos) << slam.output();
}

TEST_F(Live, ARobotOnFastDdsGivesTheOfflineMap) {
  if (!is_ros2()) GTEST_SKIP() << "is of ROS 2";
  drive_on_fastdds(testing::room_drive(), "0.5");
}

// Takes minutes: enabled on request.
TEST_F(Live, DISABLED_AWholeRealLogOnFastDdsGivesTheOfflineMap) {
  if (!is_ros2()) GTEST_SKIP() << "is of ROS 2";
  WAYFARE_NEEDS_RECORDING(log, "slam2d/intel.clf.gz");
  drive_on_fastdds(io::read_carmen(log)->recording, "5");
}

/// As the peer received them, each equal to one that we received.
template <class M>
std::vector<M> as_received(const std::string& records, const std::vector<M>& ours) {
  std::vector<M> messages;
  for (const peer::Record& record : peer::read_records(records)) {
    const auto message = ros::from_cdr<M>(record.bytes);
    EXPECT_TRUE(message && std::ranges::any_of(
                               ours, [&](const M& m) { return ros::to_cdr(m) == record.bytes; }))
        << message->header.stamp.sec;
    if (message) messages.push_back(*message);
  }
  return messages;
}

TEST_F(Live, PosesWithCovarianceAndParticlesReachFastDds) {
  if (!is_ros2()) GTEST_SKIP() << "is of ROS 2";
  const Recording& drive = testing::radar_drive();
  auto mcap = ros::RecordingWriter::create(path("radar.mcap"));
  ASSERT_TRUE(mcap && ros::write_robot(*mcap, drive) && mcap->close());
  using Pose = ros::PoseWithCovarianceStamped;
  const auto poses = listen<Pose>("pose");
  const auto particles = listen<ros::PoseArray>("particle_cloud", ros::Qos::sensor_data());
  const auto recorder = [&](const std::string& name, const std::string& type, int count,
                            Command qos) {
    Command command = {WAYFARE_FASTDDS_PEER,  "record",   "rt" + topic(name), type,
                       std::to_string(count), path(name), "--timeout-s",      "60"};
    command.insert(command.end(), qos.begin(), qos.end());
    return Process(command, path(name + ".txt"));
  };
  Process rviz = recorder("pose", "geometry_msgs/msg/PoseWithCovarianceStamped", 20, {});
  Process cloud = recorder("particle_cloud", "geometry_msgs/msg/PoseArray", 3, {"--best-effort"});
  Process slam(in_its_own_topics({WAYFARE_SLAM_NODE, "--patience-s", "20", "--settle-s", "1.5",
                                  "--sensors", "both", "--particles", "4"}),
               path("slam_of_poses.txt"));
  spin_until(kMeanwhile_s, [] { return false; });
  auto player = play(path("radar.mcap"), {"/scan", "/odom", "/radar"});
  EXPECT_TRUE(spin_until(60.0, [&] { return rviz.wait(0.0) == 0 && cloud.wait(0.0) == 0; }))
      << rviz.output() << cloud.output() << slam.output();
  EXPECT_EQ(player.wait(60.0), 0);
  EXPECT_EQ(slam.end(SIGTERM), 0) << slam.output();
  const auto received = as_received(path("pose"), *poses);
  ASSERT_EQ(received.size(), 20U);
  for (const Pose& pose : received) {
    EXPECT_EQ(pose.header.frame_id, "map");
    EXPECT_TRUE(ros::gaussian_of(pose.pose));
  }
  EXPECT_GT(received.back().pose.covariance[0], 0.0);
  for (const ros::PoseArray& array : as_received(path("particle_cloud"), *particles))
    EXPECT_EQ(array.poses.size(), 4U);
}

TEST_F(Live, WhatFastDdsSendsDamagedIsRefusedAndCounted) {
  if (!is_ros2()) GTEST_SKIP() << "is of ROS 2";
  ros::LaserScan scan;
  scan.header.stamp = {1000, 0};
  scan.header.frame_id = "laser";
  scan.angle_increment = 0.1F, scan.range_max = 10.0F;
  scan.ranges.assign(20, 1.0F);
  std::string absurd = ros::to_cdr(scan);
  for (std::size_t i = absurd.size() - 88; i < absurd.size() - 84; ++i) absurd[i] = '\xFF';
  ros::Odometry nowhere;
  nowhere.header = scan.header;
  nowhere.pose.pose.orientation.w = 1.0;
  nowhere.pose.pose.position.x = std::numeric_limits<double>::quiet_NaN();
  ros::Odometry unset = nowhere;
  unset.pose.pose.position.x = 0.0;
  unset.pose.pose.orientation.w = 0.3;
  std::ofstream file(path("bad.records"), std::ios::binary);
  std::int64_t time_ns = 0;
  const auto add = [&](const char* name, const char* type, const std::string& bytes) {
    peer::write_record(file, {time_ns += 1'000'000, "rt" + topic(name), type, bytes});
  };
  const std::string good = ros::to_cdr(scan);
  add("tf_static", "tf2_msgs/msg/TFMessage", ros::to_cdr(ros::TfMessage()));
  time_ns += static_cast<std::int64_t>(1e9 * kMeanwhile_s);
  for (const std::string& bytes : {absurd, good.substr(0, 40), good + std::string(50, 'x')})
    add("scan", "sensor_msgs/msg/LaserScan", bytes);
  for (const ros::Odometry& bad : {nowhere, unset, nowhere})
    add("odom", "nav_msgs/msg/Odometry", ros::to_cdr(bad));
  file.close();
  Process slam(in_its_own_topics({WAYFARE_SLAM_NODE}), path("slam_of_bad.txt"));
  Process robot({WAYFARE_FASTDDS_PEER, "play", path("bad.records"), "--raw", "--wait-for", "1",
                 "--transient-local"},
                path("robot.txt"));
  ASSERT_EQ(robot.wait(60.0), 0) << robot.output() << slam.output();
  const auto says = [&](const std::string& text) {
    return spin_until(30.0, [&] { return slam.output().find(text) != std::string::npos; });
  };
  EXPECT_TRUE(says("that are damaged")) << slam.output();
  EXPECT_TRUE(says("left out odometry")) << slam.output();
  EXPECT_EQ(slam.end(SIGTERM), 0);
  EXPECT_THAT(slam.output(), HasSubstr("left out in all: 3 of odometry"));
  EXPECT_THAT(slam.output(), HasSubstr(topic("scan") + ": 0 messages received, 3 refused, 0 lost"));
}

}  // namespace
}  // namespace wayfare
