// A robot's recording with an inertial unit and true poses beside its scans: choice of topics,
// mounting of the unit, and optional streams.

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>

#include <wayfare/core/se3.hpp>
#include <wayfare/ros/convert.hpp>
#include <wayfare/ros/recording.hpp>

#include "io/support.hpp"
#include "sample_recording.hpp"

namespace wayfare {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

const LogTime kStart = LogTime::from_seconds(1'600'000'000.0);

class RobotsUnit : public ::testing::Test {
 protected:
  RobotsUnit() : writer_(std::move(*ros::RecordingWriter::create(path_))) {
    for (int i = 0; i < 3; ++i) {
      const LogTime time = kStart + from_seconds(0.1 * i);
      const LaserScan scan{time, Angle(), Angle::degrees(1.0), 0.1F, 9.0F, {1.0F, 2.0F}};
      write("/scan", time, ros::message_of(scan, "base_link"));
      const OdometrySample odometry{time, {}};
      write("/odom", time, ros::message_of(odometry, "odom", "base_link"));
    }
  }
  template <class M>
  void write(const std::string& topic, LogTime time, const M& message) {
    ASSERT_TRUE(writer_.write(topic, time, message));
  }
  void write_unit(const std::string& topic, Duration off = Duration(0)) {
    for (int i = 0; i < 3; ++i) {
      const LogTime time = kStart + from_seconds(0.1 * i);
      const ImuSample sample{time + off, {0.1, 0.2, 0.3 + i}, {0.0, 0.0, 9.81}};
      write(topic, time, ros::message_of(sample, "unit"));
    }
  }
  /// By 90° about the robot's x axis: the unit's y points up, its z to the right.
  void mount_on_its_side() {
    ros::TransformStamped t = ros::transform_of(SE2d(), kStart, "base_link", "unit");
    const auto q = SO3d::exp({std::acos(0.0), 0.0, 0.0}).quaternion();
    t.transform.rotation = {q.x(), q.y(), q.z(), q.w()};
    write("/tf_static", kStart, ros::TfMessage{{t}});
  }
  Result<ros::RobotRun> read(const ros::TopicNames& names = {}) {
    EXPECT_TRUE(writer_.close());
    return ros::read_robot(*ros::RecordingFile::open(path_), names);
  }
  static std::string said(const ros::RobotRun& run) {
    std::string all;
    for (const Error& problem : run.problems.first()) all += problem.to_string() + "\n";
    return all;
  }

  testing::TemporaryFolder folder_;
  std::string path_ = folder_ / "a.bag";
  ros::RecordingWriter writer_;
};

TEST_F(RobotsUnit, GivesTheRobotsTurnRateForAnyMounting) {
  mount_on_its_side();
  write_unit("/imu");
  const auto run = read();
  ASSERT_TRUE(run) << run.error().to_string();
  EXPECT_THAT(said(*run), IsEmpty());
  ASSERT_EQ(run->recording.gyro.size(), 3U);
  for (const GyroSample& sample : run->recording.gyro)
    EXPECT_NEAR(sample.turn_rate_rad_s, 0.2, 1e-12);
  const auto marg = ros::read_marg(*ros::RecordingFile::open(path_));
  ASSERT_TRUE(marg && marg->q_base_unit);
  EXPECT_NEAR((*marg->q_base_unit * Eigen::Vector3d::UnitY()).z(), 1.0, 1e-12);
}

TEST_F(RobotsUnit, PointsUpWithoutATransform) {
  write_unit("/imu");
  const auto run = read();
  ASSERT_TRUE(run) << run.error().to_string();
  EXPECT_THAT(said(*run), HasSubstr("the unit's z axis is taken to point up"));
  ASSERT_EQ(run->recording.gyro.size(), 3U);
  EXPECT_EQ(run->recording.gyro[2].turn_rate_rad_s, 2.3);
  EXPECT_FALSE(ros::read_marg(*ros::RecordingFile::open(path_))->q_base_unit);
}

TEST_F(RobotsUnit, MustBeNamedAmongSeveral) {
  write_unit("/imu/data");
  write_unit("/imu/data_raw");
  const auto without = read();
  ASSERT_TRUE(without) << without.error().to_string();
  EXPECT_THAT(without->recording.gyro, IsEmpty());
  EXPECT_THAT(said(*without), HasSubstr("name the inertial unit among /imu/data, /imu/data_raw"));
  ros::TopicNames names;
  names.imu = "/imu/data";
  const auto with = ros::read_robot(*ros::RecordingFile::open(path_), names);
  ASSERT_TRUE(with) << with.error().to_string();
  EXPECT_EQ(with->recording.gyro.size(), 3U);
  names.imu = "/imu/none";
  EXPECT_FALSE(ros::read_robot(*ros::RecordingFile::open(path_), names));
}

TEST_F(RobotsUnit, OnAnotherClockIsDroppedUnlessNamed) {
  write_unit("/a_unit", from_seconds(50.0));
  const auto run = read();
  ASSERT_TRUE(run) << run.error().to_string();
  EXPECT_EQ(run->recording.scans.size(), 3U);
  EXPECT_THAT(run->recording.gyro, IsEmpty());
  EXPECT_THAT(said(*run), HasSubstr("/a_unit: is stamped 50.000000 s from /odom"));
  ros::TopicNames names;
  names.imu = "/a_unit";
  const auto named = ros::read_robot(*ros::RecordingFile::open(path_), names);
  ASSERT_FALSE(named);
  EXPECT_THAT(named.error().to_string(), HasSubstr("their clocks differ"));
}

TEST_F(RobotsUnit, WithoutTurnRateIsDropped) {
  ros::Imu level = ros::message_of(ImuSample{kStart, {}, {0.0, 0.0, 9.81}}, "unit");
  level.angular_velocity_covariance[0] = -1.0;
  write("/inclinometer", kStart, level);
  const auto run = read();
  ASSERT_TRUE(run) << run.error().to_string();
  EXPECT_THAT(run->recording.gyro, IsEmpty());
  EXPECT_THAT(said(*run), HasSubstr("turn rate as not measured"));
}

TEST_F(RobotsUnit, TruthMayBeASeparateOdometry) {
  const OdometrySample truth{kStart, Transform2<frame::Odom, frame::Base>(SE2d(1.0, 2.0, Angle()))};
  write("/ground_truth", kStart, ros::message_of(truth, "world", "base_link"));
  const auto ambiguous = read();
  ASSERT_FALSE(ambiguous);
  EXPECT_THAT(ambiguous.error().to_string(), HasSubstr("name the odometry"));
  ros::TopicNames names;
  names.truth = "/ground_truth";
  const auto run = ros::read_robot(*ros::RecordingFile::open(path_), names);
  ASSERT_TRUE(run) << run.error().to_string();
  EXPECT_EQ(run->odometry_topic, "/odom");
  EXPECT_EQ(run->recording.odometry.size(), 3U);
  ASSERT_EQ(run->recording.truth.size(), 1U);
  EXPECT_EQ(run->recording.truth[0].T_map_base.raw().y(), 2.0);
}

TEST_F(RobotsUnit, IsWrittenWithTheRecording) {
  const std::vector<MargSample> readings = {
      {kStart, {0.1, 0.2, 0.3}, {0.0, 0.0, 9.81}, {20.0, 0.0, 40.0}},
      {kStart + Duration(5), {0.4, 0.5, 0.6}, {0.0, 1.0, 9.81}}};
  Recording robot = testing::sample_run(2);
  auto beside = ros::RecordingWriter::create(folder_ / "unit.mcap");
  const ros::UnitRun unit{readings, SE2d(0.0, 0.0, Angle::degrees(90.0))};
  ASSERT_TRUE(ros::write_robot(*beside, robot, {}, unit) && beside->close());
  const auto file = ros::RecordingFile::open(folder_ / "unit.mcap");
  const auto marg = ros::read_marg(*file);
  ASSERT_TRUE(marg) << marg.error().to_string();
  ASSERT_EQ(marg->samples.size(), 2U);
  EXPECT_EQ(marg->samples[1].angular_rate_radps, readings[1].angular_rate_radps);
  EXPECT_EQ(marg->samples[1].specific_force_mps2, readings[1].specific_force_mps2);
  EXPECT_LT((marg->samples[0].magnetic_field_uT - readings[0].magnetic_field_uT).norm(), 1e-9);
  EXPECT_FALSE(marg->samples[1].magnetic_field_uT.allFinite());
  EXPECT_NEAR((*marg->q_base_unit * Eigen::Vector3d::UnitX()).y(), 1.0, 1e-12);
}

}  // namespace
}  // namespace wayfare
