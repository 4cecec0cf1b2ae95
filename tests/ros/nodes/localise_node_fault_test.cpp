// A localising node with bad input: time going back, another map, messages that are refused.

#include <wayfare/ros/localise_node.hpp>

#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "localised.hpp"

namespace wayfare::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();

TEST(LocaliseNode, TimeGoingBackStartsAgain) {
  Localised driven(with_initial());
  driven.add(office_map());
  driven.add(mounting(room_drive()));
  driven.drive(room_drive());
  const std::vector<LocalisationOutcome> first = std::exchange(driven.outcomes, {});
  driven.drive(room_drive());
  EXPECT_THAT(driven.said, HasSubstr("time went back by"));
  EXPECT_THAT(driven.said, HasSubstr("starts again"));
  expect_same(driven.outcomes, first);
}

TEST(LocaliseNode, KeepsThePoseOnAnotherMap) {
  const Recording& r = room_drive();
  ros::OccupancyGrid moved = office_map();
  const SE2d T_new_old(5.0, -3.0, Angle::degrees(0.0));
  moved.info.origin = ros::pose_of(T_new_old * *ros::plane_pose_of(moved.info.origin));
  Localised driven(with_initial());
  driven.add(office_map());
  driven.add(mounting(r));
  driven.drive(r);
  driven.add(office_map());
  EXPECT_THAT(driven.said, Not(HasSubstr("another map")));
  const SE2d before = driven.outcomes.back().T_map_base.mean;
  driven.add(moved);
  EXPECT_THAT(driven.said, HasSubstr("continues on another map"));
  LaserScan next = r.scans.back();
  next.time += from_seconds(0.1);
  OdometrySample still = r.odometry.back();
  still.time = next.time;
  driven.add(ros::message_of(still, "odom", "base_link"));
  driven.add(ros::message_of(next, "laser"));
  EXPECT_THAT(driven.said, HasSubstr("starts at x " + std::to_string(before.x())));
}

TEST(LocaliseNode, RefusesBadMaps) {
  Localised driven(with_initial());
  const auto refused = [&](const char* why, const auto& change) {
    ros::OccupancyGrid map = office_map();
    change(map);
    Localised other;
    other.add(map);
    EXPECT_EQ(other.left_out("map"), 1U) << why;
    EXPECT_THAT(other.said, HasSubstr(why));
    driven.add(map);
  };
  refused("cells, but has", [](auto& m) { m.info.width = 4'000'000'000; });
  refused("has no cells", [](auto& m) { m.info.height = 0, m.data.clear(); });
  refused("cells, but has", [](auto& m) { m.data.pop_back(); });
  refused("cells of nan m", [](auto& m) { m.info.resolution = std::nanf(""); });
  refused("cells of", [](auto& m) { m.info.resolution = 1e-20F; });
  refused("origin whose", [](auto& m) { m.info.origin.position.x = kNotANumber; });
  refused("origin whose", [](auto& m) { m.info.origin.orientation = {}; });
  refused("percent", [](auto& m) { m.data[7] = 101; });
  refused("not of 'map'", [](auto& m) { m.header.frame_id = "elsewhere"; });
  refused("no wall", [](auto& m) { m.data.assign(m.data.size(), 0); });
  refused("empty", [](auto& m) { m.data.assign(m.data.size(), -1); });
  EXPECT_EQ(driven.left_out("map"), 11U);
  EXPECT_EQ(driven.said, driven.said.substr(0, driven.said.find('\n') + 1)) << "said once";
  driven.add(office_map());
  driven.add(mounting(room_drive()));
  driven.drive(room_drive());
  EXPECT_EQ(driven.outcomes.size(), room_drive().scans.size());
}

TEST(LocaliseNode, RefusesBadPosesTransformsAndOdometry) {
  const Recording& r = room_drive();
  Localised driven;
  driven.add(office_map());
  const auto bad_pose = [&](const auto& change) {
    auto pose = initial_pose(begin_of(r), r.scans.front().time);
    change(pose);
    driven.add(pose);
  };
  bad_pose([](auto& p) { p.pose.pose.position.y = kNotANumber; });
  bad_pose([](auto& p) { p.pose.pose.orientation = {}; });
  bad_pose([](auto& p) { p.pose.pose.orientation.w = 2.0; });
  bad_pose([](auto& p) { p.pose.covariance[0] = -1.0; });
  bad_pose([](auto& p) { p.pose.covariance[35] = kNotANumber; });
  bad_pose([](auto& p) { p.pose.covariance[1] = 5.0; });
  bad_pose([](auto& p) { p.header.frame_id = "odom"; });
  bad_pose([](auto& p) { p.header.stamp.nanosec = 2'000'000'000; });
  EXPECT_EQ(driven.left_out("initial pose"), 8U);
  ros::TfMessage bad = mounting(r);
  bad.transforms[0].transform.rotation = {0.0, 0.0, kNotANumber, 1.0};
  bad.transforms[1].transform.translation.x = kNotANumber;
  driven.add(bad);
  EXPECT_EQ(driven.left_out("transform"), 2U);
  driven.add(mounting(r));
  driven.add(initial_pose(begin_of(r), r.scans.front().time));
  auto odometry = ros::message_of(r.odometry.front(), "odom", "base_link");
  odometry.pose.pose.orientation = {};
  driven.add(odometry);
  driven.add(odometry);
  EXPECT_EQ(driven.left_out("odometry"), 2U);
  auto scan = ros::message_of(r.scans.front(), "laser");
  scan.angle_increment = std::nanf("");
  driven.add(scan);
  EXPECT_EQ(driven.left_out("scan"), 1U);
  driven.drive(r);
  expect_same(driven.outcomes, offline(r, begin_of(r)).outcomes);
}

TEST(LocaliseNode, ContinuesWithoutMissingOdometry) {
  Localised driven(with_initial());
  driven.add(office_map());
  driven.add(mounting(room_drive()));
  for (std::size_t i = 0; i < 60; ++i) driven.add(ros::message_of(room_drive().scans[i], "laser"));
  driven.wait(3.0);
  EXPECT_THAT(driven.said, HasSubstr("continues with scans alone"));
  EXPECT_EQ(driven.outcomes.size(), 60U);
  EXPECT_THAT(driven.transforms, IsEmpty()) << "the odom frame is unknown";
}

TEST(LocaliseNode, SearchesAgainWhenAsked) {
  Localised driven(with_initial());
  driven.add(office_map());
  driven.add(mounting(room_drive()));
  const auto& scans = room_drive().scans;
  for (const OdometrySample& o : room_drive().odometry)
    driven.node.add(ros::message_of(o, "odom", "base_link"), driven.now_s);
  for (std::size_t i = 0; i < scans.size(); ++i) {
    if (i == 10) driven.node.search_everywhere();
    driven.add(ros::message_of(scans[i], "laser"));
  }
  EXPECT_TRUE(driven.outcomes[10].searched);
  EXPECT_LT(error_m(driven.outcomes.back(), room_drive()), 0.1);
}

}  // namespace
}  // namespace wayfare::testing
