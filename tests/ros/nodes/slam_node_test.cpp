// The node's logic, without ROS: missing input, clocks and publishers that restart, and
// independence of the order of arrival.

#include <optional>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <wayfare/io/map_image.hpp>
#include <wayfare/ros/detail/node_output.hpp>
#include <wayfare/ros/nodes.hpp>
#include <wayfare/sync/odometry_track.hpp>
#include "driven.hpp"
#include "room_drive.hpp"
#include "slam/carried.hpp"

namespace wayfare {
namespace {

using testing::Driven;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using testing::room_drive;

void drive(Driven& to, const Recording& r, Duration shift = Duration(0)) {
  std::size_t o = 0;
  for (LaserScan scan : r.scans) {
    for (; o < r.odometry.size() && r.odometry[o].time <= scan.time; ++o)
      to.odometry({r.odometry[o].time + shift, r.odometry[o].T_odom_base});
    scan.time += shift;
    to.scan(scan);
  }
  for (; o < r.odometry.size(); ++o)
    to.odometry({r.odometry[o].time + shift, r.odometry[o].T_odom_base});
}

ros::OccupancyGrid offline_map(const Recording& r) {
  const auto run = run_submap_slam(r);
  return ros::message_of(io::grid_image(run->map), r.scans.back().time, "map");
}

TEST(SlamNode, GivesTheOfflineMap) {
  Driven driven;
  driven.transforms();
  drive(driven, room_drive());
  driven.wait(5.0);
  const auto offline = offline_map(room_drive());
  ASSERT_TRUE(driven.map && driven.path);
  EXPECT_EQ(driven.map->data, offline.data);
  EXPECT_EQ(driven.map->info.width, offline.info.width);
  EXPECT_EQ(driven.map->header.frame_id, "map");
  EXPECT_EQ(driven.path->poses.size(), room_drive().scans.size());
  EXPECT_EQ(driven.poses.size(), room_drive().scans.size());
  EXPECT_THAT(driven.said, IsEmpty());
}

TEST(SlamNode, MapToOdomTimesOdometryIsThePose) {
  Driven driven;
  driven.transforms();
  drive(driven, room_drive());
  driven.wait(5.0);
  ASSERT_EQ(driven.transforms_out.size(), driven.poses.size());
  const OdometryTrack odometry(room_drive().odometry);
  for (std::size_t i = 0; i < driven.poses.size(); i += 7) {
    const auto& t = driven.transforms_out[i];
    EXPECT_EQ(t.header.frame_id, "map");
    EXPECT_EQ(t.child_frame_id, "odom");
    const LogTime time = *ros::time_of(driven.poses[i].header.stamp);
    EXPECT_EQ(*ros::time_of(t.header.stamp) - time, from_seconds(0.1));
    const SE2d T_map_odom = *ros::plane_pose_of(
        {{t.transform.translation.x, t.transform.translation.y, 0.0}, t.transform.rotation});
    const SE2d pose = *ros::plane_pose_of(driven.poses[i].pose.pose);
    EXPECT_LT((T_map_odom * odometry.at(time)->raw()).minus(pose).norm(), 1e-9);
  }
}

// About the map's axes, as ROS has it: x, y and yaw, the rest zero. Submaps and Hector SLAM alike,
// the first exact, as the map begins there, and the room seen as a whole no more than decimetres.
TEST(SlamNode, PublishesTheCovarianceOfPoses) {
  for (const auto system : {ros::LaserSystem::submap, ros::LaserSystem::hector}) {
    ros::SlamNodeOptions options;
    options.system = system;
    Driven driven(options);
    driven.transforms();
    drive(driven, room_drive());
    ASSERT_EQ(driven.poses.size(), room_drive().scans.size());
    EXPECT_THAT(driven.particles, IsEmpty());
    EXPECT_EQ(ros::gaussian_of(driven.poses.front().pose)->covariance, Eigen::Matrix3d::Zero());
    for (std::size_t i = 1; i < driven.poses.size(); ++i) {
      const auto pose = ros::gaussian_of(driven.poses[i].pose);
      ASSERT_TRUE(pose) << i << ": " << pose.error().to_string();
      const Eigen::Vector3d sigma = pose->covariance.diagonal().cwiseSqrt();
      EXPECT_GT(sigma.minCoeff(), 1e-4) << i;
      EXPECT_LT(sigma.head<2>().maxCoeff(), 0.3) << i;
      EXPECT_LT(sigma[2], Angle::degrees(5).radians()) << i;
      for (const std::size_t k : {14U, 21U, 28U})
        EXPECT_EQ(driven.poses[i].pose.covariance[k], 0.0) << "z, roll and pitch";
    }
  }
}

TEST(SlamNode, OrderOfArrivalDoesNotMatter) {
  Driven driven;
  const Recording& r = room_drive();
  for (const LaserScan& scan : r.scans) driven.scan(scan);
  EXPECT_THAT(driven.poses, IsEmpty());
  EXPECT_THAT(driven.node.waits_for(), HasSubstr("'base_link' to 'laser'"));
  EXPECT_THAT(driven.said, HasSubstr("waits for the transform from 'base_link' to 'laser'"));
  driven.transforms();
  driven.work();
  EXPECT_THAT(driven.node.waits_for(), HasSubstr("odometry"));
  for (const OdometrySample& sample : r.odometry) driven.odometry(sample);
  driven.wait(5.0);
  ASSERT_TRUE(driven.map);
  EXPECT_EQ(driven.map->data, offline_map(r).data);
}

TEST(SlamNode, ReportsThatItWaitsForScans) {
  Driven driven;
  driven.wait(1.0);
  EXPECT_THAT(driven.said, IsEmpty());
  driven.wait(2.0);
  EXPECT_EQ(driven.said, "waits for laser scans\n");
}

TEST(SlamNode, ContinuesWithoutMissingOdometry) {
  Driven driven;
  driven.transforms();
  for (const LaserScan& scan : room_drive().scans) driven.scan(scan);
  driven.wait(5.0);
  EXPECT_EQ(driven.poses.size(), room_drive().scans.size());
  EXPECT_THAT(driven.said, HasSubstr("continues with scans alone"));
  EXPECT_THAT(driven.transforms_out, IsEmpty()) << "the odom frame is unknown";
}

TEST(SlamNode, PublishesOdomWithoutOdometry) {
  ros::SlamNodeOptions options;
  options.odometry = false;
  Driven driven(options);
  driven.transforms();
  for (const LaserScan& scan : room_drive().scans) driven.scan(scan);
  ASSERT_EQ(driven.transforms_out.size(), 2 * driven.poses.size());
  EXPECT_EQ(driven.transforms_out[1].header.frame_id, "odom");
  EXPECT_EQ(driven.transforms_out[1].child_frame_id, "base_link");
}

TEST(SlamNode, TimeGoingBackStartsANewMap) {
  Driven driven;
  driven.transforms();
  drive(driven, room_drive(), from_seconds(500.0));
  drive(driven, room_drive());
  driven.wait(5.0);
  EXPECT_THAT(driven.said, HasSubstr("time went back by"));
  EXPECT_EQ(driven.poses.size(), 2 * room_drive().scans.size());
  ASSERT_TRUE(driven.map);
  EXPECT_EQ(driven.map->data, offline_map(room_drive()).data);
}

// Set down in a place not seen before: map and path are of the second piece alone.
TEST(SlamNode, ShowsThePieceWhereTheRobotIs) {
  const Recording r =
      carried(simulate(kFlat, slipping_robot(), 1), {{0.0, 0.08}, {0.22, 0.34}}).recording;
  Driven driven;
  driven.transforms(r);
  drive(driven, r, from_seconds(1000.0));
  driven.wait(5.0);
  EXPECT_THAT(driven.said, HasSubstr("begins piece 2"));
  EXPECT_THAT(driven.said, Not(HasSubstr("joined pieces")));
  EXPECT_EQ(driven.poses.size(), r.scans.size());
  ASSERT_TRUE(driven.map && driven.path);
  EXPECT_LT(driven.path->poses.size(), r.scans.size());
  EXPECT_GT(driven.path->poses.size(), r.scans.size() / 3);
  const SE2d end = *ros::plane_pose_of(driven.poses.back().pose.pose);
  EXPECT_LT(end.minus(*ros::plane_pose_of(driven.path->poses.back().pose)).norm(), 0.1);
  EXPECT_LT(static_cast<float>(driven.map->info.width) * driven.map->info.resolution, 35.0F);
  EXPECT_GT(driven.map->info.origin.position.x, 20.0);
}

TEST(SlamNode, JoinsThePiecesOfACarriedRobot) {
  const sim::SimulatedRun run =
      carried(simulate(kFlat, slipping_robot(), 1), {{0.5, 1.0}, {0.0, 0.5}});
  Driven driven;
  driven.transforms(run.recording);
  drive(driven, run.recording, from_seconds(1000.0));
  driven.wait(5.0);
  EXPECT_THAT(driven.said, HasSubstr("begins piece 2"));
  EXPECT_THAT(driven.said, HasSubstr("joined pieces of the trajectory: 1 of 1"));
  ASSERT_TRUE(driven.map && driven.path);
  EXPECT_EQ(driven.path->poses.size(), run.recording.scans.size());
}

TEST(SlamNode, AResetOfOdometryIsNoMotion) {
  Recording r = room_drive();
  const std::size_t half = r.odometry.size() / 2;
  const SE2d reset = SE2d(30.0, -20.0, Angle::degrees(100.0));
  for (std::size_t i = half; i < r.odometry.size(); ++i)
    r.odometry[i].T_odom_base =
        Transform2<frame::Odom, frame::Base>(reset * r.odometry[i].T_odom_base.raw());
  Driven driven;
  driven.transforms();
  drive(driven, r);
  driven.wait(5.0);
  EXPECT_THAT(driven.said, HasSubstr("odometry jumped by"));
  Driven whole;
  whole.transforms();
  drive(whole, room_drive());
  ASSERT_EQ(driven.poses.size(), whole.poses.size());
  const SE2d end = *ros::plane_pose_of(driven.poses.back().pose.pose);
  EXPECT_LT(end.minus(*ros::plane_pose_of(whole.poses.back().pose.pose)).norm(), 0.05);
  // The transform is relative to the odometry as received.
  const auto& t = driven.transforms_out.back().transform;
  const SE2d T_map_odom =
      *ros::plane_pose_of({{t.translation.x, t.translation.y, 0.0}, t.rotation});
  const LogTime time = *ros::time_of(driven.poses.back().header.stamp);
  EXPECT_LT((T_map_odom * OdometryTrack(r.odometry).at(time)->raw()).minus(end).norm(), 1e-9);
}

TEST(SlamNode, DropsUnusableMessages) {
  Driven driven;
  driven.transforms();
  auto scan = ros::message_of(room_drive().scans.front(), "laser");
  scan.header.stamp = {};
  driven.node.add(scan, driven.now_s);
  auto odometry = ros::message_of(room_drive().odometry.front(), "elsewhere", "base_link");
  driven.node.add(odometry, driven.now_s);
  driven.wait(1.0);
  EXPECT_THAT(driven.said, HasSubstr("left out a scan"));
  EXPECT_THAT(driven.said, HasSubstr("elsewhere"));
  drive(driven, room_drive());
  auto other = ros::message_of(room_drive().scans.back(), "second_laser");
  other.header.stamp.sec += 1;
  driven.node.add(other, driven.now_s);
  driven.wait(3.0);
  EXPECT_EQ(driven.poses.size(), room_drive().scans.size());
  EXPECT_THAT(driven.said, HasSubstr("second_laser"));
}

TEST(Notices, CountErrorsThatWereNotRepeated) {
  ros::Notices notices(10.0);
  for (double now_s = 0.0; now_s < 12.0; now_s += 4.0)
    notices.add(ros::Severity::error, "scan", "left out", now_s);
  notices.add(ros::Severity::error, "scan", "left out", 12.0);
  const auto said = notices.take();
  ASSERT_EQ(said.size(), 2U);
  EXPECT_EQ(said[0].text, "left out");
  EXPECT_EQ(said[1].text, "left out (2 more since)");
}

TEST(Notices, AreRepeatedAfterAWhile) {
  ros::Notices notices(10.0);
  notices.add(ros::Severity::info, "a", "first", 0.0);
  notices.add(ros::Severity::info, "a", "too soon", 9.0);
  notices.add(ros::Severity::info, "b", "other", 9.0);
  notices.add(ros::Severity::info, "a", "again", 10.0);
  const auto taken = notices.take();
  ASSERT_EQ(taken.size(), 3U);
  EXPECT_EQ(taken[1].text, "other");
  EXPECT_EQ(taken[2].text, "again");
  EXPECT_THAT(notices.take(), IsEmpty());
}

TEST(GyroTurn, IsTheSumOfRatesBetweenTheTimes) {
  const auto at = [](double s) { return LogTime::from_seconds(s); };
  const std::vector<GyroSample> samples = {
      {at(1.0), 9.0}, {at(1.1), 2.0}, {at(1.2), 3.0}, {at(2.0), 1.0}};
  const GyroTurn turn(samples);
  EXPECT_NEAR(turn.between(at(1.0), at(1.15))->radians(), 0.2 + 0.15, 1e-12);
  EXPECT_FALSE(turn.between(at(1.0), at(2.0))) << "silent for 0.8 s";
  EXPECT_FALSE(turn.between(at(1.9), at(2.1))) << "ends before";
}

}  // namespace
}  // namespace wayfare
