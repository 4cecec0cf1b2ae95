// ROS 2 recordings as read by viewers' libraries: container, schemas and CDR.

#include <algorithm>
#include <cmath>
#include <sstream>

#include <gmock/gmock.h>

#include <wayfare/ros/convert.hpp>

#include "io/node_peer.hpp"
#include "io/support.hpp"
#include "sample_recording.hpp"

namespace wayfare {
namespace {

std::string stamp(LogTime time, const char* frame) {
  const ros::Stamp s = ros::stamp_of(time);
  return std::to_string(s.sec) + " " + std::to_string(s.nanosec) + " " + frame;
}

/// The fields of a line as numbers, in any notation.
std::vector<double> numbers(const std::string& line) {
  std::istringstream words(line);
  std::vector<double> all;
  for (std::string word; words >> word;) {
    char* end = nullptr;
    const double value = std::strtod(word.c_str(), &end);
    if (*end == '\0') all.push_back(value);
  }
  return all;
}

/// Two lines with the same numbers, possibly in different notation.
void expect_line(const std::string& got, const std::string& wanted) {
  EXPECT_EQ(got.substr(0, got.find(' ', got.find("/msg/"))),
            wanted.substr(0, wanted.find(' ', wanted.find("/msg/"))));
  EXPECT_EQ(numbers(got), numbers(wanted)) << got;
}

TEST(RosMcap, IsReadByViewersLibraries) {
  const std::string missing =
      testing::peer_missing(WAYFARE_ROS_PEER, "@foxglove/rosmsg2-serialization");
  if (!missing.empty()) GTEST_SKIP() << missing;
  const testing::TemporaryFolder folder;
  const Recording run = testing::sample_run(5);
  testing::write_sample(folder / "a.mcap", run);
  int status = 0;
  std::istringstream out(testing::output_of(
      "node '" WAYFARE_ROS_PEER "/read.js' '" + folder / "a.mcap" + "' 2>&1", status));
  ASSERT_EQ(status, 0) << out.str();
  std::vector<std::string> lines;
  for (std::string line; std::getline(out, line);) lines.push_back(line);
  ASSERT_EQ(lines.size(), 1 + 1 + 5 * 5 + 3U) << out.str();
  EXPECT_EQ(lines[0], "profile ros2");
  std::ostringstream wanted;
  wanted.precision(17);
  const auto expect = [&](const std::string& got) {
    expect_line(got, wanted.str());
    wanted.str("");
  };
  wanted << "/tf_static tf2_msgs/msg/TFMessage 3 " << stamp(run.scans[0].time, "base_link")
         << " laser 0.21";
  expect(lines[1]);
  std::size_t scan = 0, odometry = 0, radar = 0, gyro = 0, truth = 0;
  for (std::size_t i = 2; i < lines.size(); ++i) {
    if (lines[i].starts_with("/scan")) {
      const LaserScan& s = run.scans[scan++];
      wanted << "/scan sensor_msgs/msg/LaserScan " << stamp(s.time, "laser") << " 481 "
             << s.ranges_m[0] << ' ' << s.ranges_m[480] << ' '
             << std::nextafter(s.max_range_m, 0.0F);
    } else if (lines[i].starts_with("/odom")) {
      const OdometrySample& o = run.odometry[odometry++];
      const ros::Pose pose = ros::pose_of(o.T_odom_base.raw());
      wanted << "/odom nav_msgs/msg/Odometry " << stamp(o.time, "odom") << " base_link "
             << pose.position.x << ' ' << pose.position.y << ' ' << pose.orientation.z << ' '
             << pose.orientation.w;
    } else if (lines[i].starts_with("/imu")) {
      const GyroSample& s = run.gyro[gyro++];
      wanted << "/imu sensor_msgs/msg/Imu " << stamp(s.time, "imu") << ' ' << s.turn_rate_rad_s
             << " -1";
    } else if (lines[i].starts_with("/truth")) {
      const StampedPose& s = run.truth[truth++];
      const ros::Pose pose = ros::pose_of(s.T_map_base.raw());
      wanted << "/truth geometry_msgs/msg/PoseStamped " << stamp(s.time, "map") << ' '
             << pose.position.x << ' ' << pose.position.y << ' ' << pose.orientation.z;
    } else if (lines[i].starts_with("/radar")) {
      const RadarScan& s = run.radar[radar++];
      wanted << "/radar wayfare_msgs/msg/RadarScan " << stamp(s.time, "radar") << ' '
             << s.points.size();
      for (const RadarPoint& p : s.points) wanted << ' ' << p.x_m;
      for (const RadarPoint& p : s.points) wanted << ' ' << p.doppler_m_s;
    } else {
      const OdometrySample& o = run.odometry[odometry - 1];
      wanted << "/tf tf2_msgs/msg/TFMessage 1 " << stamp(o.time, "odom") << " base_link "
             << o.T_odom_base.raw().x();
    }
    expect(lines[i]);
  }
  EXPECT_EQ(scan + odometry + gyro + truth + radar, 4 * 5 + 3U);
}

}  // namespace
}  // namespace wayfare
