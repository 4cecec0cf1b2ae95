// Steps from inertial messages, without ROS.

#include <algorithm>
#include <cstddef>
#include <numbers>
#include <optional>
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
  // At rest before them, the origin.
  const auto rest = given.odometry.size() - steps.size();
  EXPECT_GT(rest, 15U);
  for (std::size_t i = 0; i < rest; ++i) {
    EXPECT_LT(*ros::time_of(given.odometry[i].header.stamp), steps.front().time);
    EXPECT_EQ(given.odometry[i].pose.pose.position.x, 0.0);
    EXPECT_EQ(given.odometry[i].pose.pose.position.y, 0.0);
  }
  given.odometry.erase(given.odometry.begin(),
                       given.odometry.begin() + static_cast<std::ptrdiff_t>(rest));
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

// Stands, walks, turns by a quarter while it stands: poses follow each other within the time in
// which a walk begins or ends, none is earlier than the one before, and at rest the heading
// follows.
TEST(PedestrianNode, PublishesPosesAtRest) {
  std::vector<ImuSample> samples = walk(12.0);
  const std::size_t stood = 1000;
  const ImuSample last = samples.back();
  for (std::size_t i = 1; i <= stood; ++i) {
    ImuSample s = last;
    s.time += from_seconds(0.01 * static_cast<double>(i));
    s.specific_force_mps2 = Eigen::Vector3d(0.0, 0.0, 9.81);
    if (i > 500 && i <= 600) s.angular_rate_radps.z() = 0.5 * std::numbers::pi;
    samples.push_back(s);
  }
  ros::PedestrianNode node;
  Given given;
  std::optional<LogTime> known;
  double longest_s = 0.0, longest_at_rest_s = 0.0;
  for (const ImuSample& s : samples) {
    const std::size_t before = given.odometry.size();
    given.take(node.add(ros::message_of(s, "imu"), 0.0));
    for (std::size_t i = before; i < given.odometry.size(); ++i) {
      const LogTime time = *ros::time_of(given.odometry[i].header.stamp);
      if (known) {
        EXPECT_GT(time, *known);
      }
      known = time;
    }
    if (!known) continue;
    const double wait_s = to_seconds(s.time - *known), t = s.time.seconds() - 1000.0;
    (t < 1.9 || t > 14.0 ? longest_at_rest_s : longest_s) =
        std::max(t < 1.9 || t > 14.0 ? longest_at_rest_s : longest_s, wait_s);
  }
  // Margin, period, and half a second in which a crest may still end.
  EXPECT_LT(longest_at_rest_s, 0.92);
  // Four steps at two a second begin a walk, and a second without one ends it.
  EXPECT_LT(longest_s, 2.9);
  const auto &end = given.odometry.back().pose.pose, &step = given.odometry.front().pose.pose;
  const auto turned = *ros::yaw_of(step.orientation) * SO2d(Angle::degrees(90.0));
  EXPECT_NEAR((turned.inverse() * *ros::yaw_of(end.orientation)).angle().degrees(), 0.0, 2.0);
  EXPECT_EQ(given.odometry.back().twist.twist.linear.x, 0.0);
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
