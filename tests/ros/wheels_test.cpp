// Wheels in a recording: restored from what was written, computed from joints of any robot, and
// what is wrong with them.

#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>

#include <wayfare/core/random.hpp>
#include <wayfare/ros/convert.hpp>
#include <wayfare/ros/recording.hpp>

#include "io/support.hpp"
#include "sample_recording.hpp"

namespace wayfare {
namespace {

using ::testing::DoubleNear;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::sample_run;
using testing::TemporaryFolder;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
const LogTime kFirst = LogTime::from_seconds(1'600'000'000.0);
LogTime wheel_time(int i) { return kFirst + from_seconds(0.1 * i); }

std::string said(const io::Problems& problems) {
  std::string all;
  for (const Error& error : problems.first()) all += error.to_string() + "\n";
  return all;
}

/// Wheels with distances that are multiples of `count_m`; arbitrary ones for zero.
Recording with_wheels(double count_m) {
  Recording r = sample_run(200);
  Rng rng(3);
  r.wheel_base_m = 0.287;
  r.radar_max_speed_m_s = 0.9736;
  const auto roll = [&] {
    const double m = 0.05 * rng.uniform() - 0.01;
    return count_m > 0.0 ? count_m * std::round(m / count_m) : m;
  };
  for (std::size_t i = 0; i < r.scans.size(); ++i)
    r.wheels.push_back({r.scans[i].time, i == 0 ? 0.0 : roll(), i == 0 ? 0.0 : roll()});
  return r;
}

class WheelsRestored : public ::testing::TestWithParam<const char*> {
 protected:
  Recording restored(const Recording& written) {
    const std::string path = folder_ / "a" + GetParam();
    testing::write_sample(path, written);
    const auto run = ros::read_robot(*ros::RecordingFile::open(path));
    EXPECT_TRUE(run) << run.error().to_string();
    EXPECT_EQ(run->wheel_topic, "/joint_states");
    EXPECT_EQ(run->recording.wheels.size(), written.wheels.size());
    EXPECT_EQ(run->recording.wheel_base_m, written.wheel_base_m);
    EXPECT_EQ(run->recording.radar_max_speed_m_s, written.radar_max_speed_m_s);
    return run->recording;
  }
  TemporaryFolder folder_;
};

TEST_P(WheelsRestored, ToTheBitFromCounts) {
  // Sums of multiples of 2^-16 m below 2^36 m are exact, and so are they over a radius of 2^-5 m.
  const Recording written = with_wheels(std::ldexp(1.0, -16)), read = restored(written);
  for (std::size_t i = 0; i < read.wheels.size(); ++i) {
    ASSERT_EQ(read.wheels[i].time, written.wheels[i].time) << i;
    ASSERT_EQ(read.wheels[i].left_m, written.wheels[i].left_m) << i;
    ASSERT_EQ(read.wheels[i].right_m, written.wheels[i].right_m) << i;
  }
}

TEST_P(WheelsRestored, ToTheLastBitOfTheSumFromAnyNumbers) {
  const Recording written = with_wheels(0.0), read = restored(written);
  double left_m = 0.0;
  long double sum_m = 0.0L;
  for (std::size_t i = 0; i < read.wheels.size(); ++i) {
    left_m += read.wheels[i].left_m;  // exact: differences of the positions that were written
    sum_m += static_cast<long double>(written.wheels[i].left_m);
    // Within half a unit of the last place.
    const double unit_m = std::ldexp(1.0, std::ilogb(std::max(1e-3, std::abs(left_m))) - 52);
    ASSERT_LE(std::abs(static_cast<double>(static_cast<long double>(left_m) - sum_m)), unit_m) << i;
    // Of this position and of the one before, whose unit is at most twice as large.
    ASSERT_LE(std::abs(read.wheels[i].left_m - written.wheels[i].left_m), 3.0 * unit_m) << i;
  }
  EXPECT_GT(left_m, 1.0);
}

TEST_P(WheelsRestored, WithoutTheirDistanceIfItIsUnknown) {
  Recording written = with_wheels(0.0);
  written.wheel_base_m = 0.0;
  written.radar_max_speed_m_s = 0.0;
  restored(written);
}

INSTANTIATE_TEST_SUITE_P(Both, WheelsRestored, ::testing::Values(".bag", ".mcap"),
                         [](const auto& of) { return std::string(of.param).substr(1); });

/// A robot of its own names: wheels `l` and `r` beside an arm.
class Wheels : public ::testing::Test {
 protected:
  Wheels() {
    names_.wheels.names = {"l", "r"};
    names_.wheels.radius_m = 0.1;
    names_.wheels.base_m = 0.5;
    for (int i = 0; i < 3; ++i) {
      const LaserScan scan{wheel_time(i), Angle(), Angle::degrees(1.0), 0.1F, 9.0F, {1.0F, 2.0F}};
      write("/scan", i, ros::message_of(scan, "base_link"));
    }
  }
  template <class M>
  void write(const std::string& topic, int i, const M& message) {
    ASSERT_TRUE(writer_.write(topic, wheel_time(i), message));
  }
  void write_joints(int i, std::vector<std::string> names, std::vector<double> positions,
                    std::vector<double> velocities = {}) {
    ros::JointState m;
    m.header = ros::header_of(wheel_time(i), "");
    m.name = std::move(names), m.position = std::move(positions);
    m.velocity = std::move(velocities);
    write("/joint_states", i, m);
  }
  void write_positions(const std::vector<double>& left_rad, const std::vector<double>& right_rad) {
    for (std::size_t i = 0; i < left_rad.size(); ++i)
      write_joints(static_cast<int>(i), {"arm", "r", "l"}, {0.5, right_rad[i], left_rad[i]});
  }
  void describe(const std::string& urdf) {
    write("/robot_description", 0, ros::String{urdf});
    names_.wheels.radius_m.reset(), names_.wheels.base_m.reset();
  }
  static std::string why(const Result<ros::RobotRun>& run) {
    return run ? "no error" : run.error().to_string();
  }
  Result<ros::RobotRun> read() {
    EXPECT_TRUE(writer_.close());
    return ros::read_robot(*ros::RecordingFile::open(path_), names_);
  }
  std::string why() { return why(read()); }
  ros::RobotRun run() {
    auto result = read();
    EXPECT_TRUE(result) << result.error().to_string();
    return *std::move(result);
  }

  TemporaryFolder folder_;
  std::string path_ = folder_ / "a.bag";
  ros::RecordingWriter writer_ = std::move(*ros::RecordingWriter::create(path_));
  ros::TopicNames names_;
};

TEST_F(Wheels, RollTheirRadiusPerRadian) {
  write_positions({1.0, 1.5, 1.5}, {-2.0, -1.0, 0.0});
  const ros::RobotRun found = run();
  ASSERT_EQ(found.recording.wheels.size(), 3U);
  EXPECT_EQ(found.recording.wheel_base_m, 0.5);
  const double left_m[] = {0.0, 0.05, 0.0}, right_m[] = {0.0, 0.1, 0.1};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_THAT(found.recording.wheels[i].left_m, DoubleNear(left_m[i], 1e-15));
    EXPECT_THAT(found.recording.wheels[i].right_m, DoubleNear(right_m[i], 1e-15));
  }
  EXPECT_TRUE(found.problems.empty()) << said(found.problems);
}

TEST_F(Wheels, AreIntegratedFromVelocitiesWithoutPositions) {
  for (int i = 0; i < 3; ++i) write_joints(i, {"l", "r"}, {}, {2.0 * i, 3.0});
  const ros::RobotRun found = run();
  ASSERT_EQ(found.recording.wheels.size(), 3U);
  // 0.1 m radius, 0.1 s: the mean of 0 and 2, then of 2 and 4 rad/s.
  EXPECT_THAT(found.recording.wheels[1].left_m, DoubleNear(0.01, 1e-9));
  EXPECT_THAT(found.recording.wheels[2].right_m, DoubleNear(0.03, 1e-9));
}

TEST_F(Wheels, MayBeAbsentFromSomeMessages) {
  write_joints(0, {"l", "r"}, {0.0, 0.0});
  write_joints(1, {"arm"}, {7.0});
  write_joints(2, {"r", "l"}, {2.0, 1.0});
  const ros::RobotRun found = run();
  ASSERT_EQ(found.recording.wheels.size(), 2U);
  EXPECT_THAT(found.recording.wheels[1].left_m, DoubleNear(0.1, 1e-15));
  EXPECT_TRUE(found.problems.empty()) << said(found.problems);
}

TEST_F(Wheels, ThatAreNotThereAreListed) {
  write_positions({0.0, 1.0}, {0.0, 1.0});
  names_.wheels.names = {"left", "right"};
  EXPECT_THAT(why(), HasSubstr("/joint_states: has no wheel 'left'; there is arm, l, r"));
}

TEST_F(Wheels, NeedBothNames) {
  write_positions({0.0, 1.0}, {0.0, 1.0});
  names_.wheels.names = {"l", "right"};
  EXPECT_THAT(why(),
              HasSubstr("/joint_states:1: name has 'l' without 'right'; there is arm, r, l"));
}

TEST_F(Wheels, ThatAreNotNamedAreNotMissed) {
  write_positions({0.0, 1.0}, {0.0, 1.0});
  names_ = {};
  const ros::RobotRun found = run();
  EXPECT_THAT(found.recording.wheels, IsEmpty());
  EXPECT_TRUE(found.problems.empty()) << said(found.problems);
}

TEST_F(Wheels, NeedARadius) {
  write_positions({0.0, 1.0}, {0.0, 1.0});
  names_.wheels.radius_m.reset();
  EXPECT_THAT(why(), HasSubstr("their radius is neither given nor in a robot description"));
}

TEST_F(Wheels, NeedATopic) { EXPECT_THAT(why(), HasSubstr("has no wheels (sensor_msgs")); }

TEST_F(Wheels, NeedSoundNumbers) {
  write_positions({0.0, 1.0}, {0.0, 1.0});
  ASSERT_TRUE(writer_.close());
  const auto file = ros::RecordingFile::open(path_);
  const auto error = [&](double radius_m, double base_m, const std::string& right) {
    names_.wheels.names = {"l", right};
    names_.wheels.radius_m = radius_m, names_.wheels.base_m = base_m;
    return why(ros::read_robot(*file, names_));
  };
  for (const double bad : {0.0, -0.1, kNan, std::numeric_limits<double>::infinity()}) {
    EXPECT_THAT(error(bad, 0.5, "r"), HasSubstr("wheel radius: must be a positive number of m"));
    EXPECT_THAT(error(0.1, bad, "r"), HasSubstr("wheel base: must be a positive number of m"));
  }
  EXPECT_THAT(error(0.1, 0.5, "l"), HasSubstr("must be two joints"));
  EXPECT_EQ(error(0.1, 0.5, "r"), "no error");
  names_.radar_max_speed_mps = kNan;
  EXPECT_THAT(why(ros::read_robot(*file, names_)), HasSubstr("positive speed"));
}

TEST_F(Wheels, NeedNumbersInTheMessages) {
  write_joints(0, {"l", "r"}, {0.0, 0.0});
  write_joints(1, {"l", "r"}, {kNan, 0.0});
  write_joints(2, {"l", "r"}, {0.1, 0.2, 0.3});
  write_joints(3, {"l", "r"}, {0.4, 0.4});
  const ros::RobotRun found = run();
  EXPECT_THAT(said(found.problems),
              HasSubstr("/joint_states:2: position of a wheel is not finite"));
  EXPECT_THAT(said(found.problems), HasSubstr("/joint_states:3: position has 3 values for 2"));
  ASSERT_EQ(found.recording.wheels.size(), 2U);
  EXPECT_THAT(found.recording.wheels[1].left_m, DoubleNear(0.04, 1e-15));
}

TEST_F(Wheels, ThatJumpKeepTheirSpeed) {
  // An encoder that begins again at zero, at 1 m/s: 1 rad in 0.1 s at a radius of 0.1 m.
  write_positions({500.0, 501.0, 0.0, 1.0}, {0.0, 1.0, 2.0, 3.0});
  const ros::RobotRun found = run();
  EXPECT_THAT(said(found.problems), HasSubstr("a wheel jumps by 50.100 m in 0.100 s"));
  ASSERT_EQ(found.recording.wheels.size(), 4U);
  for (std::size_t i = 1; i < 4; ++i)
    EXPECT_THAT(found.recording.wheels[i].left_m, DoubleNear(0.1, 1e-9)) << i;
}

TEST_F(Wheels, ThatAlwaysJumpAreRefused) {
  write_positions({0.0, 1000.0, 0.0, 1000.0}, {0.0, 1.0, 2.0, 3.0});
  EXPECT_THAT(why(), HasSubstr("jumps in most of its messages: wheels of 0.1 m radius"));
}

constexpr const char* kRobot = R"(<?xml version="1.0"?>
<!-- <joint name="l"><origin xyz="0 9 0"/></joint> -->
<robot name='r2'>
  <link name="base_link"/>
  <link name="left > link"><visual><geometry><mesh filename="a.stl"/></geometry></visual>
    <collision><geometry><cylinder length="0.02" radius="0.033"/></geometry></collision></link>
  <link name="right"><collision><geometry><cylinder radius="RIGHT" length="0.02"/></geometry>
    <origin xyz="7 7 7"/></collision></link>
  <joint name="l" type="continuous"><parent link="base_link"/><child link="left > link"/>
    <origin rpy="-1.57 0 0" xyz="-0.032 LEFT_Y 0.023"/></joint>
  <joint name="r" type="continuous"><parent link="base_link"/><child link="right"/>
    <origin rpy="-1.57 0 0" xyz="-0.032 -8e-2 0.023"/></joint>
  <ros2_control><joint name="l"/><joint name="r"/><origin xyz="1 1 1"/></ros2_control>
</robot>)";

std::string robot(const std::string& left_y, const std::string& right_radius) {
  std::string text = kRobot;
  text.replace(text.find("LEFT_Y"), 6, left_y);
  return text.replace(text.find("RIGHT\""), 5, right_radius);
}

TEST_F(Wheels, MayBeDescribed) {
  write_positions({0.0, 1.0}, {0.0, 2.0});
  describe(robot("0.08", "0.033"));
  const ros::RobotRun found = run();
  ASSERT_EQ(found.recording.wheels.size(), 2U);
  EXPECT_THAT(found.recording.wheel_base_m, DoubleNear(0.16, 1e-15));
  EXPECT_THAT(found.recording.wheels[1].right_m, DoubleNear(0.066, 1e-15));
}

TEST_F(Wheels, OfDifferentRadiiAreRefused) {
  write_positions({0.0, 1.0}, {0.0, 2.0});
  describe(robot("0.08", "0.035"));
  EXPECT_THAT(why(),
              HasSubstr("/robot_description: has wheels of different radii: 0.033 and 0.035 m"));
}

TEST_F(Wheels, ThatAreExchangedAreRefused) {
  write_positions({0.0, 1.0}, {0.0, 2.0});
  describe(robot("-0.08001", "0.033"));
  EXPECT_THAT(why(), HasSubstr("has 'l' on the right of 'r': left and right are exchanged"));
}

TEST_F(Wheels, ADescriptionOfNonsenseIsNone) {
  write_positions({0.0, 1.0}, {0.0, 2.0});
  describe("<robot><joint name=\"l\"><origin xyz=\"nan\"/><joint name=\"<<<");
  EXPECT_THAT(why(), HasSubstr("their radius is neither given nor in a robot description"));
}

/// Twenty seconds of turns at ±0.5 rad/s; the wheels, 0.5 m apart, turn `factor` times as far.
class WheelsAndGyro : public Wheels {
 protected:
  std::string problems(double factor) {
    double turned = 0.0;
    for (int i = 0; i <= 200; ++i) {
      const double rate = i <= 100 ? 0.5 : -0.5;
      turned += i == 0 ? 0.0 : 0.1 * rate;
      const double rolled_rad = 0.5 * factor * turned * 0.5 / 0.1;
      write_joints(i, {"l", "r"}, {-rolled_rad, rolled_rad});
      write("/imu", i, ros::message_of(GyroSample{wheel_time(i), rate + 0.03}, "base_link"));
    }
    const ros::RobotRun found = run();
    EXPECT_EQ(found.recording.wheels.size(), 201U) << "doubted, not dropped";
    return said(found.problems);
  }
};

TEST_F(WheelsAndGyro, ThatAgreeAreNotDoubted) { EXPECT_THAT(problems(1.0), IsEmpty()); }
TEST_F(WheelsAndGyro, ThatAgreeButForSlipAreNotDoubted) { EXPECT_THAT(problems(1.2), IsEmpty()); }
TEST_F(WheelsAndGyro, OfAnotherBaseAreNamed) {
  // The gyro turns by 0.53 or -0.47 rad/s, by wheels as 1 and -1: 1 · 0.5 / (0.53² + 0.47²) · 2.
  EXPECT_THAT(problems(2.0),
              HasSubstr("the wheels contradict the gyro in 10 of 10 turns: they turn "
                        "1.99 times as far, a wheel base of 0.996 m instead of "
                        "0.500 m would agree"));
}
TEST_F(WheelsAndGyro, OfExchangedSidesAreNamed) {
  EXPECT_THAT(problems(-1.0),
              HasSubstr("are left and right exchanged, or the unit mounted upside"));
}
TEST_F(WheelsAndGyro, OfWheelsThatStandAreNamed) {
  EXPECT_THAT(problems(0.0), HasSubstr("0.00 times as far, the wheels hardly turn"));
}

}  // namespace
}  // namespace wayfare
