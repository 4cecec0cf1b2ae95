// The node with radar, without ROS: its map is the offline one, for any order of messages.

#include <algorithm>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <wayfare/io/map_image.hpp>
#include <wayfare/ros/nodes.hpp>
#include <wayfare/sync/odometry_track.hpp>
#include "driven.hpp"
#include "room_drive.hpp"

namespace wayfare {
namespace {

using testing::Driven;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using testing::radar_drive;

RadarSlamOptions few() {
  RadarSlamOptions options;
  options.particles = 4;
  return options;
}

Driven driven_by(SlamSensors sensors, double patience_s = 2.0) {
  ros::SlamNodeOptions options;
  options.sensors = sensors;
  options.filter = few();
  options.patience_s = patience_s;
  Driven driven(options);
  driven.step_s = 0.01;
  return driven;
}

/// All messages in order of their stamps.
void drive(Driven& to, Duration shift = Duration(0)) {
  std::vector<std::pair<LogTime, std::function<void()>>> all;
  const auto later = [shift](auto item) {
    item.time += shift;
    return item;
  };
  const auto send = [&](const auto& items, auto how) {
    for (const auto& item : items)
      all.emplace_back(item.time, [&to, how, message = later(item)] { how(to, message); });
  };
  send(radar_drive().scans, [](Driven& d, const LaserScan& m) { d.scan(m); });
  send(radar_drive().radar, [](Driven& d, const RadarScan& m) { d.radar(m); });
  send(radar_drive().odometry, [](Driven& d, const OdometrySample& m) { d.odometry(m); });
  std::stable_sort(all.begin(), all.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  for (const auto& message : all) message.second();
}

struct Offline {
  ros::OccupancyGrid map;
  std::size_t poses = 0;
};
Offline offline(SlamSensors sensors) {
  const auto run = run_radar_slam(radar_drive(), few(), sensors);
  const LogTime last = run->trajectory.back().time;
  return {ros::message_of(io::grid_image(run->map()), last, "map"), run->trajectory.size()};
}

void expect_as_offline(const Driven& driven, SlamSensors sensors) {
  const Offline expected = offline(sensors);
  ASSERT_TRUE(driven.map && driven.path);
  EXPECT_EQ(driven.map->data, expected.map.data);
  EXPECT_EQ(driven.map->info.width, expected.map.info.width);
  EXPECT_EQ(driven.map->header.stamp, expected.map.header.stamp);
  EXPECT_EQ(driven.path->poses.size(), expected.poses);
}

TEST(SlamNodeWithRadar, GivesTheOfflineMap) {
  for (const SlamSensors sensors : {SlamSensors::radar, SlamSensors::both}) {
    Driven driven = driven_by(sensors);
    driven.transforms(radar_drive());
    drive(driven);
    driven.wait(3.0);
    expect_as_offline(driven, sensors);
    EXPECT_EQ(driven.poses.size(), driven.path->poses.size());
    EXPECT_THAT(driven.said, IsEmpty());
    const OdometryTrack odometry(radar_drive().odometry);
    ASSERT_EQ(driven.transforms_out.size(), driven.poses.size());
    const auto& t = driven.transforms_out.back().transform;
    const SE2d T_map_odom =
        *ros::plane_pose_of({{t.translation.x, t.translation.y, 0.0}, t.rotation});
    const SE2d pose = *ros::plane_pose_of(driven.poses.back().pose.pose);
    const LogTime time = *ros::time_of(driven.poses.back().header.stamp);
    EXPECT_LT((T_map_odom * odometry.at(time)->raw()).minus(pose).norm(), 1e-9);
  }
}

// All of them twice a second, about the poses.
TEST(SlamNodeWithRadar, PublishesParticlesAndCovariances) {
  Driven driven = driven_by(SlamSensors::both);
  driven.transforms(radar_drive());
  drive(driven);
  ASSERT_THAT(driven.particles, Not(IsEmpty()));
  const auto time = [](const auto& message) { return *ros::time_of(message.header.stamp); };
  const double lasted_s = to_seconds(time(driven.poses.back()) - time(driven.poses.front()));
  EXPECT_LE(static_cast<double>(driven.particles.size()), 1.0 + lasted_s / 0.5);
  EXPECT_GE(static_cast<double>(driven.particles.size()), 0.5 * lasted_s);
  for (const ros::PoseArray& cloud : driven.particles) {
    EXPECT_EQ(cloud.header.frame_id, "map");
    EXPECT_EQ(cloud.poses.size(), few().particles);
    const auto pose = std::ranges::find_if(
        driven.poses, [&](const auto& p) { return p.header.stamp == cloud.header.stamp; });
    ASSERT_NE(pose, driven.poses.end());
    const SE2d at = *ros::plane_pose_of(pose->pose.pose);
    for (const ros::Pose& particle : cloud.poses)
      EXPECT_LT(at.minus(*ros::plane_pose_of(particle)).norm(), 1.0);
  }
  for (std::size_t i = 1; i < driven.poses.size(); ++i)
    EXPECT_TRUE(ros::gaussian_of(driven.poses[i].pose)) << i;
  EXPECT_GT(driven.poses.back().pose.covariance[0], 0.0);
}

TEST(SlamNodeWithRadar, OrderOfArrivalDoesNotMatter) {
  Driven driven = driven_by(SlamSensors::both, 1e9);
  driven.wait(0.1);
  EXPECT_EQ(driven.node.waits_for(), "laser scans");
  for (const LaserScan& scan : radar_drive().scans) driven.scan(scan);
  EXPECT_EQ(driven.node.waits_for(), "radar scans");
  for (const RadarScan& scan : radar_drive().radar) driven.radar(scan);
  EXPECT_THAT(driven.node.waits_for(), HasSubstr("'base_link' to 'laser'"));
  driven.transforms(radar_drive());
  driven.work();
  EXPECT_THAT(driven.node.waits_for(), HasSubstr("odometry"));
  for (const OdometrySample& sample : radar_drive().odometry) driven.odometry(sample);
  driven.wait(3.0);
  expect_as_offline(driven, SlamSensors::both);
}

TEST(SlamNodeWithRadar, AcceptsCloudsButOnlyOneMessageType) {
  Driven driven = driven_by(SlamSensors::radar, 1e9);
  driven.transforms(radar_drive());
  for (const RadarScan& scan : radar_drive().radar) {
    driven.cloud(scan);
    driven.radar(scan);
  }
  for (const OdometrySample& sample : radar_drive().odometry) driven.odometry(sample);
  driven.wait(3.0);
  expect_as_offline(driven, SlamSensors::radar);
  EXPECT_THAT(driven.said, IsEmpty());
}

TEST(SlamNodeWithRadar, ContinuesWithoutMissingOdometry) {
  Driven driven = driven_by(SlamSensors::radar);
  driven.transforms(radar_drive());
  for (const RadarScan& scan : radar_drive().radar) driven.radar(scan);
  driven.wait(6.0);
  EXPECT_GE(driven.poses.size(), offline(SlamSensors::radar).poses);
  EXPECT_THAT(driven.said, HasSubstr("no odometry at the scan's time: continues without"));
  EXPECT_THAT(driven.transforms_out, IsEmpty()) << "the odom frame is unknown";
}

TEST(SlamNodeWithRadar, TimeGoingBackStartsANewMap) {
  Driven driven = driven_by(SlamSensors::both);
  driven.transforms(radar_drive());
  drive(driven, from_seconds(500.0));
  drive(driven);
  driven.wait(3.0);
  EXPECT_THAT(driven.said, HasSubstr("time went back by"));
  expect_as_offline(driven, SlamSensors::both);
}

}  // namespace
}  // namespace wayfare
