// Localisation as a node, without ROS: the same bits as on a recording, independence of the order
// of arrival, and poses given by the user.

#include <wayfare/ros/localise_node.hpp>

#include <cstddef>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <wayfare/io/carmen.hpp>
#include <wayfare/io/map_image.hpp>
#include <wayfare/ros/scan_node.hpp>
#include <wayfare/sim/simulate_recording.hpp>
#include <wayfare/slam/submap_slam.hpp>
#include <wayfare/sync/odometry_track.hpp>
#include "io/support.hpp"
#include "localised.hpp"

namespace wayfare::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(LocaliseNode, GivesTheOfflinePoses) {
  Localised driven(with_initial());
  driven.add(office_map());
  driven.add(mounting(room_drive()));
  driven.drive(room_drive());
  const LocalisationRun run = offline(room_drive(), begin_of(room_drive()));
  expect_same(driven.outcomes, run.outcomes);
  const Trajectory converged = run.trajectory(true);
  ASSERT_EQ(driven.poses.size(), converged.size());
  EXPECT_GT(converged.size(), run.outcomes.size() / 2);
  for (std::size_t i = 0; i < converged.size(); ++i) {
    const SE2d pose = *ros::plane_pose_of(driven.poses[i].pose.pose);
    ASSERT_LT(pose.minus(converged[i].T_map_base.raw()).norm(), 1e-12);
    EXPECT_EQ(driven.poses[i].header.frame_id, "map");
    EXPECT_EQ(*ros::time_of(driven.poses[i].header.stamp), converged[i].time);
  }
  EXPECT_LT(error_m(driven.outcomes.back(), room_drive()), 0.1);
  EXPECT_THAT(driven.said, HasSubstr("starts at x"));
  EXPECT_THAT(driven.said, HasSubstr("localised at x"));
  EXPECT_THAT(driven.node.left_out(), IsEmpty());
}

// On the map that submap SLAM makes of the same scans.
TEST(LocaliseNode, GivesTheOfflinePosesOfARealLog) {
  WAYFARE_NEEDS_RECORDING(path, "slam2d/intel.clf.gz");
  Recording r = io::read_carmen(path)->recording;
  constexpr std::size_t kScans = WAYFARE_TEST_SCANS;
  if (kScans > 0 && r.scans.size() > kScans) r.scans.resize(kScans);
  const auto slam = run_submap_slam(r);
  const auto map = ros::message_of(io::grid_image(slam->map), r.scans.front().time, "map");
  ros::LocaliseNodeOptions options;
  options.initial = Gaussian<SE2d>{slam->trajectory.front().T_map_base.raw()};
  options.initial->covariance *= 0.1;
  Localised driven(options);
  driven.add(map);
  driven.add(mounting(r));
  driven.drive(r);
  const LocalisationRun run = offline(r, options.initial, map);
  expect_same(driven.outcomes, run.outcomes);
  const std::size_t converged = run.trajectory(true).size();
  EXPECT_EQ(driven.poses.size(), converged);
  EXPECT_GT(converged, run.outcomes.size() * 9 / 10);
  std::printf("%zu of %zu scans localised\n", converged, run.outcomes.size());
}

TEST(LocaliseNode, MapToOdomTimesOdometryIsThePoseAndPostDated) {
  Localised driven(with_initial());
  driven.add(office_map());
  driven.add(mounting(room_drive()));
  driven.drive(room_drive());
  ASSERT_EQ(driven.transforms.size(), driven.poses.size());
  const OdometryTrack odometry(room_drive().odometry);
  for (std::size_t i = 0; i < driven.poses.size(); i += 5) {
    const auto& t = driven.transforms[i];
    EXPECT_EQ(t.header.frame_id, "map");
    EXPECT_EQ(t.child_frame_id, "odom");
    const LogTime time = *ros::time_of(driven.poses[i].header.stamp);
    EXPECT_EQ(*ros::time_of(t.header.stamp) - time, from_seconds(0.1));
    const SE2d T_map_odom = *ros::plane_pose_of(
        {{t.transform.translation.x, t.transform.translation.y, 0.0}, t.transform.rotation});
    const SE2d pose = *ros::plane_pose_of(driven.poses[i].pose.pose);
    EXPECT_LT((T_map_odom * odometry.at(time)->raw()).minus(pose).norm(), 1e-9);
  }
  // Half a second apart, and of the filter's size.
  ASSERT_GT(driven.clouds.size(), 5U);
  EXPECT_GE(
      *ros::time_of(driven.clouds[1].header.stamp) - *ros::time_of(driven.clouds[0].header.stamp),
      from_seconds(0.5));
  double weight = 0.0;
  for (const ros::Particle& p : driven.clouds.back().particles) weight += p.weight;
  EXPECT_NEAR(weight, 1.0, 1e-9);
}

TEST(LocaliseNode, TakesOdometryFromTransforms) {
  ros::LocaliseNodeOptions options = with_initial();
  options.source = ros::OdometrySource::transforms;
  Localised driven(options);
  driven.add(office_map());
  ros::TfMessage fixed = mounting(room_drive());
  fixed.transforms.push_back(
      ros::transform_of(SE2d(), room_drive().scans[0].time, "base_footprint", "base_link"));
  driven.add(fixed);
  driven.drive(room_drive(), true);
  const LocalisationRun run = offline(room_drive(), begin_of(room_drive()));
  ASSERT_EQ(driven.outcomes.size(), run.outcomes.size());
  EXPECT_LT(error_m(driven.outcomes.back(), room_drive()), 0.1);
  EXPECT_EQ(driven.transforms.size(), driven.poses.size());
}

TEST(LocaliseNode, OrderOfArrivalDoesNotMatter) {
  Localised driven;
  const Recording& r = room_drive();
  for (const LaserScan& scan : r.scans) driven.node.add(ros::message_of(scan, "laser"), 100.0);
  driven.wait(3.0);
  EXPECT_THAT(driven.said, HasSubstr("waits for a map"));
  // Before scans are given up as too old for a pose.
  driven.node.add(initial_pose(begin_of(r), r.scans.front().time), driven.now_s);
  driven.add(office_map());
  EXPECT_THAT(driven.node.waits_for(), HasSubstr("'base_link' to 'laser'"));
  driven.add(mounting(r));
  EXPECT_THAT(driven.node.waits_for(), HasSubstr("odometry"));
  for (const OdometrySample& o : r.odometry)
    driven.node.add(ros::message_of(o, "odom", "base_link"), driven.now_s);
  driven.work();
  expect_same(driven.outcomes, offline(r, begin_of(r)).outcomes);
}

TEST(LocaliseNode, SearchesTheWholeMap) {
  ros::LocaliseNodeOptions options;
  options.global = true;
  Localised driven(options);
  driven.add(office_map());
  driven.add(mounting(room_drive()));
  driven.drive(room_drive());
  const LocalisationRun run = offline(room_drive(), std::nullopt);
  expect_same(driven.outcomes, run.outcomes);
  EXPECT_TRUE(driven.outcomes.back().converged);
  EXPECT_LT(error_m(driven.outcomes.back(), room_drive()), 0.1);
  EXPECT_THAT(driven.said, HasSubstr("searches the whole map"));
}

TEST(LocaliseNode, WaitsForAnInitialPoseAndMovesItByOdometry) {
  const Recording& r = room_drive();
  Localised driven;
  driven.add(office_map());
  driven.add(mounting(r));
  for (const auto& odometry : r.odometry)
    driven.node.add(ros::message_of(odometry, "odom", "base_link"), driven.now_s);
  const std::size_t third = r.scans.size() / 3;
  for (std::size_t i = 0; i < third; ++i) driven.add(ros::message_of(r.scans[i], "laser"));
  driven.wait(3.0);
  EXPECT_THAT(driven.said, HasSubstr("waits for the robot's initial pose"));
  EXPECT_THAT(driven.outcomes, IsEmpty());
  EXPECT_THAT(driven.transforms, IsEmpty());
  // Between two scans, sharp: at the next scan the robot is elsewhere.
  const LogTime between =
      r.scans[third - 1].time + (r.scans[third].time - r.scans[third - 1].time) / 2;
  Gaussian<SE2d> given{*pose_at(r.truth, between)};
  given.covariance = Eigen::Vector3d(1e-4, 1e-4, 1e-5).asDiagonal();
  driven.add(initial_pose(given, between));
  driven.add(ros::message_of(r.scans[third], "laser"));
  ASSERT_EQ(driven.outcomes.size(), 1U);
  EXPECT_LT(error_m(driven.outcomes[0], r), 0.05);
  // Again, three seconds late, while the robot drives on.
  const std::size_t later = third + 30;
  for (std::size_t i = third + 1; i < later; ++i) driven.add(ros::message_of(r.scans[i], "laser"));
  driven.add(initial_pose(given, between));
  driven.add(ros::message_of(r.scans[later], "laser"));
  EXPECT_LT(error_m(driven.outcomes.back(), r), 0.1);
  EXPECT_GT(
      (pose_at(r.truth, r.scans[later].time)->translation() - given.mean.translation()).norm(), 0.3)
      << "the test needs motion";
}

TEST(LocaliseNode, TakesAPoseOfAnotherClockAsItIs) {
  Localised driven;
  driven.add(office_map());
  driven.add(mounting(room_drive()));
  driven.add(initial_pose(begin_of(room_drive()), LogTime::from_seconds(1.7e9)));
  driven.drive(room_drive());
  EXPECT_THAT(driven.said, HasSubstr("after the scan: taken as the pose at the scan"));
  EXPECT_EQ(driven.outcomes.size(), room_drive().scans.size());
  EXPECT_LT(error_m(driven.outcomes.back(), room_drive()), 0.1);
}

TEST(LocaliseNode, FindsAKidnappedRobot) {
  const Recording& whole = room_drive();
  const auto at = [&](double share) {
    return whole.scans[static_cast<std::size_t>(share * static_cast<double>(whole.scans.size()))]
        .time;
  };
  const Recording r = sim::kidnapped(whole, at(0.15), at(0.4));
  Localised driven(with_initial());
  driven.add(office_map());
  driven.add(mounting(r));
  driven.drive(r);
  expect_same(driven.outcomes, offline(r, begin_of(r)).outcomes);
  EXPECT_THAT(driven.said, HasSubstr("the robot was carried: found at x"));
  EXPECT_TRUE(driven.outcomes.back().converged);
  EXPECT_LT(error_m(driven.outcomes.back(), r), 0.1);
}

TEST(LocaliseNode, CovarianceIsAboutTheAxesOfTheMap) {
  // A robot that faces left, uncertain along its own x: in the map along y.
  Gaussian<SE2d> pose{SE2d(1.0, 2.0, Angle::degrees(90.0))};
  pose.covariance = Eigen::Vector3d(4.0, 1.0, 0.25).asDiagonal();
  const auto message = initial_pose(pose, LogTime::from_seconds(5.0));
  EXPECT_NEAR(message.pose.covariance[0], 1.0, 1e-12);
  EXPECT_NEAR(message.pose.covariance[7], 4.0, 1e-12);
  EXPECT_EQ(message.pose.covariance[35], 0.25);
  const auto back = ros::gaussian_of(message.pose);
  ASSERT_TRUE(back);
  EXPECT_LT((back->covariance - pose.covariance).norm(), 1e-12);
}

TEST(LocaliseNode, MapsKeepTheirCellSizeInDecimals) {
  io::GridImage image{2, 1, 0.05, SE2d(-1.0, 2.0, Angle::degrees(30.0)), {0.25F, 1.0F}};
  const auto back = ros::grid_image_of(ros::message_of(image, LogTime::from_seconds(5.0), "map"));
  ASSERT_TRUE(back);
  EXPECT_EQ(back->resolution_m, 0.05);
  EXPECT_EQ(back->occupancy, image.occupancy);
  EXPECT_TRUE(same_bits(back->origin, image.origin));
}

}  // namespace
}  // namespace wayfare::testing
