// Pedestrian SLAM and Hector SLAM with an inertial unit as nodes, without ROS: the offline
// trajectory, and input that is missing.

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <wayfare/ros/nodes.hpp>
#include <wayfare/slam/hector_slam.hpp>
#include <wayfare/slam/pedestrian_slam.hpp>
#include "driven.hpp"
#include "head_walk.hpp"

namespace wayfare {
namespace {

using testing::Driven;
using ::testing::HasSubstr;
using testing::head_walk;
using testing::HeadWalk;
using ::testing::IsEmpty;

const HeadWalk& walked() {
  static const HeadWalk walk = head_walk(LogTime::from_seconds(1000.0));
  return walk;
}

ros::SlamNodeOptions walker_options() {
  ros::SlamNodeOptions o;
  o.system = ros::LaserSystem::pedestrian;
  o.walker.pedestrian.length = ConstantStep{0.66};
  o.unit_forward = Eigen::Vector3d::UnitX();
  o.T_base_laser = Transform2<frame::Base, frame::Laser>(SE2d());
  return o;
}

PedestrianSlamOptions offline(const ros::SlamNodeOptions& o) {
  PedestrianSlamOptions options = o.walker;
  options.pedestrian.forward = Eigen::Vector3d::UnitX();
  return options;
}

/// Samples and scans in order of time.
void follow(Driven& to, const HeadWalk& walk) {
  auto sample = walk.unit.begin();
  for (const LaserScan& scan : walk.log.scans) {
    to.scan(scan);
    for (; sample != walk.unit.end() && sample->time <= scan.time; ++sample) to.sample(*sample);
  }
  for (; sample != walk.unit.end(); ++sample) to.sample(*sample);
}

void expect_path(const Driven& driven, const Trajectory& trajectory, double tolerance = 0.0) {
  ASSERT_TRUE(driven.path);
  ASSERT_EQ(driven.path->poses.size(), trajectory.size());
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    const ros::Pose& live = driven.path->poses[i].pose;
    const ros::Pose offline = ros::pose_of(trajectory[i].T_map_base.raw());
    EXPECT_NEAR(live.position.x, offline.position.x, tolerance) << i;
    EXPECT_NEAR(live.position.y, offline.position.y, tolerance) << i;
    EXPECT_NEAR(live.orientation.z, offline.orientation.z, tolerance) << i;
    EXPECT_NEAR(live.orientation.w, offline.orientation.w, tolerance) << i;
    EXPECT_EQ(*ros::time_of(driven.path->poses[i].header.stamp), trajectory[i].time) << i;
  }
}

TEST(WalkerNode, GivesTheOfflineTrajectory) {
  Driven driven(walker_options());
  driven.step_s = 0.01;
  follow(driven, walked());
  driven.wait(5.0);
  const auto run = run_pedestrian_slam(walked().log, walked().unit, offline(walker_options()));
  ASSERT_TRUE(run);
  expect_path(driven, run->slam.trajectory);
  EXPECT_EQ(driven.poses.size(), walked().log.scans.size());
  EXPECT_THAT(driven.said, IsEmpty());
  // No odometry: the node gives both transforms.
  EXPECT_EQ(driven.transforms_out.size(), 2 * driven.poses.size());
  const auto& truth = walked().truth_m;
  const double walked_m = (truth.back() - truth.front()).norm();
  const auto& end = driven.path->poses.back().pose.position;
  EXPECT_NEAR(std::hypot(end.x, end.y), walked_m, 0.15);
}

// The unit tells that the walker stands: each scan is placed with the sample of its time.
TEST(WalkerNode, AScanAtRestWaitsForNoStep) {
  Driven driven(walker_options());
  driven.step_s = 0.01;
  auto sample = walked().unit.begin();
  std::size_t at_rest = 0;
  for (const LaserScan& scan : walked().log.scans) {
    if (scan.time > LogTime::from_seconds(1003.5)) break;
    for (; sample->time <= scan.time; ++sample) driven.sample(*sample);
    driven.scan(scan);
    if (sample->time > scan.time) driven.sample(*sample++);
    EXPECT_EQ(driven.poses.size(), ++at_rest);
  }
  EXPECT_GT(at_rest, 10U);
  EXPECT_THAT(driven.said, IsEmpty());
}

TEST(WalkerNode, MountingFromTransformsIsThatOfTheOption) {
  ros::SlamNodeOptions o = walker_options();
  o.unit_forward.reset(), o.T_base_laser.reset();
  Driven driven(o);
  driven.step_s = 0.01;
  driven.wait(3.0);
  EXPECT_THAT(driven.said, HasSubstr("waits for laser scans"));
  driven.scan(walked().log.scans.front());
  driven.wait(3.0);
  EXPECT_THAT(driven.said, HasSubstr("waits for the transform from 'base_link' to 'laser'"));
  const LogTime time = LogTime::from_seconds(1.0);
  driven.node.add(ros::TfMessage{{ros::transform_of(SE2d(), time, "base_link", "laser")}});
  driven.wait(3.0);
  EXPECT_THAT(driven.said, HasSubstr("waits for inertial samples"));
  driven.sample(walked().unit.front());
  driven.wait(3.0);
  EXPECT_THAT(driven.said, HasSubstr("waits for the transform from 'base_link' to 'imu'"));
  EXPECT_THAT(driven.poses, IsEmpty());
  driven.node.add(ros::TfMessage{{ros::transform_of(SE2d(), time, "base_link", "imu")}});
  HeadWalk rest = walked();
  rest.log.scans.erase(rest.log.scans.begin()), rest.unit.erase(rest.unit.begin());
  follow(driven, rest);
  driven.wait(5.0);
  const auto run = run_pedestrian_slam(walked().log, walked().unit, offline(walker_options()));
  expect_path(driven, run->slam.trajectory);
}

// A unit that falls silent, speaks of another frame, or sends nonsense.
TEST(WalkerNode, ReportsAnInterruptedUnit) {
  Driven driven(walker_options());
  HeadWalk walk = walked();
  std::erase_if(walk.unit, [](const MargSample& s) { return s.time.seconds() > 1009.0; });
  follow(driven, walk);
  driven.wait(5.0);
  EXPECT_THAT(driven.said, HasSubstr("no inertial samples at the scan's time: continues with scans "
                                     "alone"));
  EXPECT_EQ(driven.poses.size(), walk.log.scans.size());
  driven.node.add(ros::message_of(ImuSample{LogTime::from_seconds(2000.0)}, "other"),
                  driven.now_s);
  driven.work();
  EXPECT_THAT(driven.said, HasSubstr("left out an inertial sample"));
  EXPECT_THAT(driven.said, HasSubstr("other"));
}

// One message of a magnetometer for each sample: the times are those of one sensor, or of two.
TEST(WalkerNode, UsesAMagnetometerWithoutTheMapsHeading) {
  for (const double late_s : {0.0, 0.004}) {
    ros::SlamNodeOptions o = walker_options();
    o.walker.heading = false;
    o.magnetometer = true;
    Driven driven(o);
    driven.step_s = 0.01;
    MargRecording with_field;
    const Eigen::Vector3d field(20.0, 0.0, -40.0);
    auto scan = walked().log.scans.begin();
    const auto end = LogTime::from_seconds(1012.0);
    for (const MargSample& s : walked().unit) {
      if (s.time > end) break;
      const LogTime at = s.time + from_seconds(late_s);
      for (; scan->time < s.time; ++scan) driven.scan(*scan);
      driven.node.add(ros::magnetic_message_of(field, at, "imu"), driven.now_s);
      driven.sample(s);
      with_field.push_back(s);
      if (late_s > 0.0) with_field.push_back({at});
      with_field.back().magnetic_field_uT = 1e6 * (1e-6 * field);
    }
    driven.wait(5.0);
    Recording log = walked().log;
    log.scans.resize(driven.poses.size());
    EXPECT_GT(log.scans.size(), 40U);
    const auto run = run_pedestrian_slam(log, with_field, offline(o));
    ASSERT_TRUE(run);
    expect_path(driven, run->slam.trajectory);
  }
}

TEST(HectorNode, GivesTheOfflineTrajectory) {
  ros::SlamNodeOptions o;
  o.system = ros::LaserSystem::hector;
  o.odometry = false, o.imu = true;
  o.unit_forward = Eigen::Vector3d::UnitX();
  o.T_base_laser = Transform2<frame::Base, frame::Laser>(SE2d());
  Driven driven(o);
  driven.step_s = 0.01;
  follow(driven, walked());
  driven.wait(5.0);
  const auto run = run_hector_slam(walked().log, walked().unit);
  ASSERT_TRUE(run);
  EXPECT_GT(run->statistics.fused_scans, 50U);
  expect_path(driven, run->trajectory);
  EXPECT_THAT(driven.said, IsEmpty());
}

// A heading that was no angle within ±π loses its last bit in a message's quaternion.
TEST(HectorNode, WithOdometryGivesTheOfflineTrajectory) {
  ros::SlamNodeOptions o;
  o.system = ros::LaserSystem::hector;
  Driven driven(o);
  driven.transforms();
  const Recording& r = testing::room_drive();
  for (const OdometrySample& sample : r.odometry) driven.odometry(sample);
  for (const LaserScan& scan : r.scans) driven.scan(scan);
  driven.wait(5.0);
  const auto run = run_hector_slam(r);
  ASSERT_TRUE(run);
  expect_path(driven, run->trajectory, 1e-9);
  EXPECT_EQ(driven.transforms_out.size(), driven.poses.size());
}

}  // namespace
}  // namespace wayfare
