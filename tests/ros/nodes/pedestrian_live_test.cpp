// The pedestrian node as a process: samples in, steps out.

#include <signal.h>

#include <optional>
#include <string>
#include <vector>

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
  EXPECT_TRUE(spin_until(10.0, [&] { return transforms->size() >= offline.size(); }));
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

}  // namespace
}  // namespace wayfare
