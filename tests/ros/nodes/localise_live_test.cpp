// The localising node as a process: map and pose in, poses of the offline run out.

#include <signal.h>

#include <string>

#include <wayfare/ros/recording.hpp>
#include "live.hpp"
#include "localised.hpp"

namespace wayfare {
namespace {

using testing::Live;
using testing::Process;

TEST_F(Live, ADriveOnAKnownMapGivesTheOfflinePoses) {
  const Recording& drive = testing::room_drive();
  auto bag = ros::RecordingWriter::create(path("known.bag"));
  ASSERT_TRUE(bag);
  ASSERT_TRUE(ros::write_robot(*bag, drive));
  ASSERT_TRUE(bag->close());
  auto map = node_->publisher<ros::OccupancyGrid>(topic("map"), ros::Qos::latched());
  map.publish(testing::office_map());
  Process localiser(in_its_own_topics({WAYFARE_LOCALISE_NODE, "--patience-s", "20"}),
                    path("localise_node.txt"));
  const auto poses = listen<ros::PoseWithCovarianceStamped>("amcl_pose");
  const auto clouds = listen<ros::ParticleCloud>("particle_cloud", ros::Qos::sensor_data(100));
  auto initial = node_->publisher<ros::PoseWithCovarianceStamped>(topic("initialpose"));
  ASSERT_TRUE(spin_until(30.0, [&] { return initial.subscribers() == 1; })) << localiser.output();
  initial.publish(testing::initial_pose(testing::begin_of(drive), drive.scans.front().time));
  // The node's writers find the test's readers a little later than its readers the test's writers.
  spin_until(2.0, [] { return false; });
  ASSERT_EQ(play(path("known.bag"), {"/scan", "/odom"}).wait(120.0), 0) << localiser.output();
  const Trajectory offline = testing::offline(drive, testing::begin_of(drive)).trajectory(true);
  EXPECT_TRUE(spin_until(30.0, [&] { return poses->size() >= offline.size(); }))
      << localiser.output();
  ASSERT_EQ(poses->size(), offline.size()) << localiser.output();
  for (std::size_t i = 0; i < offline.size(); ++i) {
    const SE2d pose = *ros::plane_pose_of((*poses)[i].pose.pose);
    ASSERT_LT(pose.minus(offline[i].T_map_base.raw()).norm(), 1e-9) << i;
    EXPECT_EQ(*ros::time_of((*poses)[i].header.stamp), offline[i].time);
  }
  EXPECT_FALSE(clouds->empty());
  EXPECT_EQ(localiser.end(SIGTERM), 0) << localiser.output();
}

}  // namespace
}  // namespace wayfare
