// Steps from inertial messages, without ROS.

#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <wayfare/ros/nodes.hpp>
#include "walk.hpp"

namespace wayfare {
namespace {

using ::testing::HasSubstr;
using testing::walk;

struct Given {
  std::vector<ros::Odometry> odometry;
  std::string said;

  void take(const ros::PedestrianNodeOutput& out) {
    odometry.insert(odometry.end(), out.odometry.begin(), out.odometry.end());
    for (const ros::Notice& n : out.notices) said += n.text + "\n";
  }
};

TEST(PedestrianNode, PublishesEveryStepOfTheDeadReckoning) {
  ros::PedestrianNode node;
  Pedestrian reckoning;
  std::vector<PedestrianPose> steps;
  Given given;
  for (const ImuSample& s : walk(12.0)) {
    given.take(node.add(ros::message_of(s, "imu"), 0.0));
    reckoning.add({s.time, s.angular_rate_radps, s.specific_force_mps2},
                  [&](const PedestrianPose& p) { steps.push_back(p); });
  }
  ASSERT_GT(steps.size(), 10U);
  ASSERT_EQ(given.odometry.size(), steps.size());
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const ros::Odometry& m = given.odometry[i];
    EXPECT_EQ(*ros::time_of(m.header.stamp), steps[i].time);
    EXPECT_EQ(m.header.frame_id, "odom");
    EXPECT_EQ(m.child_frame_id, "base_link");
    EXPECT_DOUBLE_EQ(m.pose.pose.position.x, steps[i].position_m.x());
    EXPECT_DOUBLE_EQ(m.pose.pose.position.y, steps[i].position_m.y());
    EXPECT_DOUBLE_EQ(m.pose.covariance[7], steps[i].covariance(1, 1));
    EXPECT_DOUBLE_EQ(m.pose.covariance[35], steps[i].covariance(2, 2));
    EXPECT_DOUBLE_EQ(m.pose.covariance[5], steps[i].covariance(0, 2));
  }
  // Two steps per second, with this number of metres each.
  const ros::Odometry& last = given.odometry.back();
  EXPECT_NEAR(last.twist.twist.linear.x, 2.0 * steps.back().length_m, 0.05);
}

TEST(PedestrianNode, RestartsWhenTimeGoesBack) {
  ros::PedestrianNode node;
  Given first, second;
  for (const ImuSample& s : walk(12.0)) first.take(node.add(ros::message_of(s, "imu"), 0.0));
  for (const ImuSample& s : walk(12.0)) second.take(node.add(ros::message_of(s, "imu"), 20.0));
  EXPECT_THAT(second.said, HasSubstr("time went back by"));
  ASSERT_EQ(second.odometry.size(), first.odometry.size());
  EXPECT_EQ(second.odometry.back().pose.pose.position.x,
            first.odometry.back().pose.pose.position.x);
}

TEST(PedestrianNode, ReportsMissingAndInvalidInput) {
  ros::PedestrianNode node;
  Given given;
  given.take(node.idle(1.0));
  given.take(node.idle(2.0));
  EXPECT_EQ(given.said, "");
  given.take(node.idle(3.5));
  EXPECT_EQ(given.said, "waits for inertial samples\n");
  given.take(node.add(ros::Imu{}, 4.0));
  EXPECT_THAT(given.said, HasSubstr("left out an inertial sample"));
}

}  // namespace
}  // namespace wayfare
