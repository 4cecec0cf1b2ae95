// The pedestrian node as a process: samples in, steps out.

#include <signal.h>

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include <wayfare/io/text_file.hpp>
#include <wayfare/ros/nodes.hpp>
#include <wayfare/ros/recording.hpp>
#include "live.hpp"
#include "walk.hpp"

namespace wayfare {
namespace {

using testing::Live;
using testing::Process;

std::vector<std::string> odometry_made_offline(const std::vector<ImuSample>& samples) {
  std::vector<std::string> messages;
  std::optional<PedestrianPose> before;
  Pedestrian reckoning;
  for (const ImuSample& s : samples)
    reckoning.add({s.time, s.angular_rate_radps, s.specific_force_mps2},
                  [&](const PedestrianPose& pose) {
                    messages.push_back(
                        ros::to_ros1(ros::odometry_message(pose, before, "odom", "base_link")));
                    before = pose;
                  });
  return messages;
}

/// Removes the poses at rest, which come before the steps of the walk.
void remove_rest(std::vector<ros::Odometry>& odometry) {
  const auto at_origin = [](const ros::Odometry& m) {
    return m.pose.pose.position.x == 0.0 && m.pose.pose.position.y == 0.0;
  };
  EXPECT_GT(std::erase_if(odometry, at_origin), 10U);
}

TEST_F(Live, AWalkGivesTheOfflineSteps) {
  const auto samples = testing::walk(20.0);
  auto bag = ros::RecordingWriter::create(path("walk.bag"));
  ASSERT_TRUE(bag);
  for (const ImuSample& s : samples)
    ASSERT_TRUE(bag->write("/imu", s.time, ros::message_of(s, "imu")));
  ASSERT_TRUE(bag->close());

  Process node(in_its_own_topics({WAYFARE_PEDESTRIAN_NODE}), path("pedestrian_node.txt"));
  const auto steps = listen<ros::Odometry>("odom");
  const auto transforms = listen<ros::TfMessage>("tf");
  EXPECT_TRUE(spin_until(30.0, [&] {
    return node.output().find("waits for inertial samples") != std::string::npos;
  })) << node.output();
  ASSERT_EQ(play(path("walk.bag"), {"/imu"}).wait(60.0), 0) << node.output();

  const auto offline = odometry_made_offline(samples);
  ASSERT_GE(offline.size(), 20U);
  const auto last_stamp = ros::from_ros1<ros::Odometry>(offline.back())->header.stamp;
  EXPECT_TRUE(spin_until(10.0, [&] {
    return transforms->size() == steps->size() && !steps->empty() &&
           steps->back().header.stamp == last_stamp;
  })) << node.output();
  remove_rest(*steps);
  ASSERT_EQ(steps->size(), offline.size()) << node.output();
  for (std::size_t i = 0; i < steps->size(); ++i) {
    // ROS 1 numbers a topic's messages in their headers.
    ros::Odometry step = (*steps)[i];
    step.header.seq = 0;
    EXPECT_EQ(ros::to_ros1(step), offline[i]) << i;
    EXPECT_EQ((*transforms)[i].transforms.front().child_frame_id, "base_link");
  }
  EXPECT_EQ(node.end(SIGTERM), 0);
}

// Steps of 1.25 m by a calibration file; one that is none ends the node with its name.
TEST_F(Live, TheCalibrationScalesTheSteps) {
  ASSERT_TRUE(io::write_file(path("constant.json"), R"({"length": "constant", "factor": 1.25})",
                             {io::Existing::replace}));
  ASSERT_TRUE(io::write_file(path("none.json"), "{}", {io::Existing::replace}));
  auto bag = ros::RecordingWriter::create(path("calibrated.bag"));
  ASSERT_TRUE(bag);
  for (const ImuSample& s : testing::walk(12.0))
    ASSERT_TRUE(bag->write("/imu", s.time, ros::message_of(s, "imu")));
  ASSERT_TRUE(bag->close());
  const std::string calibration = "--calibration";
  Process refused(in_its_own_topics({WAYFARE_PEDESTRIAN_NODE, calibration, path("none.json")}),
                  path("refused.txt"));
  EXPECT_EQ(refused.wait(60.0), 1);
  EXPECT_NE(refused.output().find("none.json: needs 'length'"), std::string::npos)
      << refused.output();

  Process node(in_its_own_topics({WAYFARE_PEDESTRIAN_NODE, calibration, path("constant.json")}),
               path("calibrated.txt"));
  const auto steps = listen<ros::Odometry>("odom");
  EXPECT_TRUE(spin_until(30.0, [&] {
    return node.output().find("waits for inertial samples") != std::string::npos;
  })) << node.output();
  ASSERT_EQ(play(path("calibrated.bag"), {"/imu"}).wait(60.0), 0) << node.output();
  EXPECT_TRUE(spin_until(10.0, [&] { return steps->size() >= 30; }));
  remove_rest(*steps);
  ASSERT_GE(steps->size(), 10U) << node.output();
  for (std::size_t i = 1; i < steps->size(); ++i) {
    const auto &a = (*steps)[i - 1].pose.pose.position, &b = (*steps)[i].pose.pose.position;
    EXPECT_NEAR(std::hypot(b.x - a.x, b.y - a.y), 1.25, 1e-9) << i;
  }
  EXPECT_EQ(node.end(SIGTERM), 0);
}

}  // namespace
}  // namespace wayfare
