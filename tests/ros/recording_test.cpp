// Recordings of ROS messages: round trips to the bit in both containers; errors for topics, frames
// and clocks that do not fit.

#include <wayfare/ros/recording.hpp>

#include <gmock/gmock.h>

#include <wayfare/io/carmen.hpp>
#include <wayfare/ros/convert.hpp>

#include "io/support.hpp"
#include "sample_recording.hpp"

namespace wayfare {
namespace {

using ::testing::HasSubstr;
using testing::sample_run;
using testing::TemporaryFolder;
using testing::write_sample;

const LogTime kTime = LogTime::from_nanoseconds(1'600'000'000'000'000'000);

bool same(const SE2d& a, const SE2d& b) {
  return a.translation() == b.translation() && a.rotation().cos() == b.rotation().cos() &&
         a.rotation().sin() == b.rotation().sin();
}

bool same(const LaserScan& a, const LaserScan& b) {
  bool equal = a.time == b.time && a.first_bearing.radians() == b.first_bearing.radians() &&
               a.bearing_step.radians() == b.bearing_step.radians() &&
               a.min_range_m == b.min_range_m && a.max_range_m == b.max_range_m &&
               a.ranges_m.size() == b.ranges_m.size();
  for (std::size_t i = 0; equal && i < a.ranges_m.size(); ++i)
    equal =
        a.ranges_m[i] == b.ranges_m[i] || (std::isnan(a.ranges_m[i]) && std::isnan(b.ranges_m[i]));
  return equal;
}

void expect_same(const Recording& read, const Recording& wanted) {
  ASSERT_EQ(read.scans.size(), wanted.scans.size());
  for (std::size_t i = 0; i < read.scans.size(); ++i)
    ASSERT_TRUE(same(read.scans[i], wanted.scans[i])) << i;
  ASSERT_EQ(read.odometry.size(), wanted.odometry.size());
  for (std::size_t i = 0; i < read.odometry.size(); ++i) {
    ASSERT_EQ(read.odometry[i].time, wanted.odometry[i].time) << i;
    ASSERT_TRUE(same(read.odometry[i].T_odom_base.raw(), wanted.odometry[i].T_odom_base.raw()))
        << i;
  }
  ASSERT_EQ(read.gyro.size(), wanted.gyro.size());
  for (std::size_t i = 0; i < read.gyro.size(); ++i) {
    ASSERT_EQ(read.gyro[i].time, wanted.gyro[i].time) << i;
    ASSERT_EQ(read.gyro[i].turn_rate_rad_s, wanted.gyro[i].turn_rate_rad_s) << i;
  }
  ASSERT_EQ(read.truth.size(), wanted.truth.size());
  for (std::size_t i = 0; i < read.truth.size(); ++i) {
    ASSERT_EQ(read.truth[i].time, wanted.truth[i].time) << i;
    ASSERT_TRUE(same(read.truth[i].T_map_base.raw(), wanted.truth[i].T_map_base.raw())) << i;
  }
  ASSERT_EQ(read.radar.size(), wanted.radar.size());
  for (std::size_t i = 0; i < read.radar.size(); ++i) {
    ASSERT_EQ(read.radar[i].time, wanted.radar[i].time) << i;
    ASSERT_EQ(read.radar[i].points, wanted.radar[i].points) << i;
  }
  EXPECT_TRUE(same(read.T_base_laser.raw(), wanted.T_base_laser.raw()));
  EXPECT_TRUE(same(read.T_base_radar.raw(), wanted.T_base_radar.raw()));
}

//! [read]
Result<ros::RobotRun> read_back(const std::string& path, const ros::TopicNames& names = {}) {
  const auto file = ros::RecordingFile::open(path);
  if (!file) return file.error();
  return ros::read_robot(*file, names);
}
//! [read]

template <class T>
std::string why(const Result<T>& result) {
  return result ? "no error" : result.error().to_string();
}

class Recordings : public ::testing::TestWithParam<const char*> {
 protected:
  [[nodiscard]] std::string path(const std::string& name = "a") const {
    return folder_ / name + GetParam();
  }
  TemporaryFolder folder_;
};

//! [round trip]
TEST_P(Recordings, RoundTripToTheBit) {
  const Recording wanted = sample_run(300);
  write_sample(path(), wanted);
  EXPECT_TRUE(ros::RecordingFile::is_one(path()));
  const auto run = read_back(path());
  ASSERT_TRUE(run) << why(run);
  EXPECT_TRUE(run->problems.empty()) << run->problems.first()[0].to_string();
  EXPECT_EQ(run->scan_topic, "/scan");
  EXPECT_EQ(run->radar_topic, "/radar");
  expect_same(run->recording, wanted);
}
//! [round trip]

TEST_P(Recordings, OfARealLogRoundTripToTheBit) {
  WAYFARE_NEEDS_RECORDING(log, "slam2d/intel.clf.gz");
  const auto wanted = io::read_carmen(log);
  ASSERT_TRUE(wanted) << wanted.error().to_string();
  write_sample(path(), wanted->recording);
  const auto run = read_back(path());
  ASSERT_TRUE(run) << why(run);
  expect_same(run->recording, wanted->recording);
}

TEST_P(Recordings, TruncatedAreReadToTheirEnd) {
  write_sample(path(), sample_run(1000));
  const std::string bytes = io::read_file(path())->bytes;
  ASSERT_TRUE(io::write_file(path("cut"), bytes.substr(0, bytes.size() * 6 / 10)));
  const auto run = read_back(path("cut"));
  ASSERT_TRUE(run) << why(run);
  EXPECT_FALSE(run->problems.empty());
  EXPECT_GT(run->recording.scans.size(), 300U);
  EXPECT_LT(run->recording.scans.size(), 700U);
  EXPECT_TRUE(same(run->recording.scans[99], sample_run(100).scans[99]));
}

/// Three scans on each of two topics, odometry with a clock offset, no transforms.
void write_odd(const std::string& path, const std::string& second, Duration off,
               const std::string& frame = "laser") {
  auto writer = ros::RecordingWriter::create(path);
  for (int i = 0; i < 3; ++i) {
    const LogTime time = kTime + from_seconds(0.1 * i);
    const LaserScan scan{time, Angle(), Angle::degrees(1.0), 0.1F, 9.0F, {1.0F, 2.0F}};
    ASSERT_TRUE(writer->write("/front", time, ros::message_of(scan, frame)));
    if (!second.empty()) {
      ASSERT_TRUE(writer->write(second, time, ros::message_of(scan, "rear")));
    }
    const OdometrySample odometry{time + off, {}};
    ASSERT_TRUE(writer->write("/odom", time, ros::message_of(odometry, "odom", "base_link")));
  }
  ASSERT_TRUE(writer->close());
}

TEST_P(Recordings, SeveralTopicsOfATypeMustBeNamed) {
  write_odd(path(), "/rear", Duration(0));
  EXPECT_THAT(
      why(read_back(path())),
      HasSubstr("several topics of sensor_msgs/LaserScan: name the scan among /front, /rear"));
  ros::TopicNames names;
  names.scan = "/side";
  EXPECT_THAT(why(read_back(path(), names)), HasSubstr("no topic /side of sensor_msgs/LaserScan"));
  names.scan = "/rear";
  const auto run = read_back(path(), names);
  ASSERT_TRUE(run) << why(run);
  EXPECT_EQ(run->recording.scans.size(), 3U);
  // Without a transform of the laser: reported once.
  ASSERT_EQ(run->problems.count(), 1U);
  EXPECT_THAT(run->problems.first()[0].to_string(),
              HasSubstr("frame rear: no transform leads from 'base_link' to 'rear'"));
}

TEST_P(Recordings, ReportsDifferentClocks) {
  write_odd(path(), "", from_seconds(-50.0));
  EXPECT_THAT(why(read_back(path())), HasSubstr("/odom: is stamped -50.000000 s from /front"));
  ros::TopicNames names;
  names.stamps = ros::StampSource::received;
  const auto run = read_back(path(), names);
  ASSERT_TRUE(run) << why(run);
  EXPECT_EQ(run->recording.odometry[1].time, run->recording.scans[1].time);
}

TEST_P(Recordings, WithoutAScanAreRefused) {
  auto writer = ros::RecordingWriter::create(path());
  ASSERT_TRUE(writer->write("/imu", kTime, ros::message_of(ImuSample{kTime}, "imu")));
  ASSERT_TRUE(writer->close());
  EXPECT_THAT(why(read_back(path())), HasSubstr("has no laser scan and no radar points"));
}

TEST_P(Recordings, TransformsReplaceMissingOdometry) {
  auto writer = ros::RecordingWriter::create(path());
  for (int i = 0; i < 3; ++i) {
    const LogTime time = kTime + from_seconds(0.1 * i);
    const LaserScan scan{time, Angle(), Angle::degrees(1.0), 0.1F, 9.0F, {1.0F, 2.0F}};
    ASSERT_TRUE(writer->write("/scan", time, ros::message_of(scan, "base_footprint")));
    ASSERT_TRUE(writer->write("/tf", time,
                              ros::TfMessage{{ros::transform_of(SE2d(0.1 * i, 0.0, Angle()), time,
                                                                "odom", "base_footprint")}}));
  }
  ASSERT_TRUE(writer->close());
  const auto run = read_back(path());
  ASSERT_TRUE(run) << why(run);
  EXPECT_TRUE(run->problems.empty());
  ASSERT_EQ(run->recording.odometry.size(), 3U);
  EXPECT_EQ(run->recording.odometry[2].T_odom_base.raw().x(), 0.2);
}

TEST_P(Recordings, OfAnInertialUnitIncludeItsMagnetometer) {
  auto writer = ros::RecordingWriter::create(path());
  for (int i = 0; i < 4; ++i) {
    const LogTime time = kTime + from_seconds(0.01 * i);
    ASSERT_TRUE(writer->write("/imu", time,
                              ros::message_of(ImuSample{time, {0.1, 0.2, 0.3}, {0, 0, 9.8}}, "i")));
    const LogTime field = i == 1 ? time : time + Duration(1000);
    ASSERT_TRUE(writer->write("/mag", field, ros::magnetic_message_of({20, 0, 40}, field, "i")));
  }
  ASSERT_TRUE(writer->close());
  const auto run = ros::read_marg(*ros::RecordingFile::open(path()));
  ASSERT_TRUE(run) << why(run);
  ASSERT_EQ(run->samples.size(), 7U);  // one sample has the unit's stamp
  EXPECT_TRUE(run->samples[2].angular_rate_radps.allFinite());
  EXPECT_TRUE(run->samples[2].magnetic_field_uT.allFinite());
  EXPECT_FALSE(run->samples[1].angular_rate_radps.allFinite());
  EXPECT_EQ(ros::read_vehicle(*ros::RecordingFile::open(path()))->imu.size(), 4U);
}

INSTANTIATE_TEST_SUITE_P(Containers, Recordings, ::testing::Values(".bag", ".mcap"),
                         [](const auto& kind) { return std::string(kind.param).substr(1); });

TEST(FrameTree, FindsPosesUpAndDown) {
  ros::FrameTree tree;
  tree.add(ros::transform_of(SE2d(1.0, 0.0, Angle::degrees(90.0)), kTime, "/base_link", "plate"));
  tree.add(ros::transform_of(SE2d(0.0, 2.0, Angle()), kTime, "plate", "laser"));
  tree.add(ros::transform_of(SE2d(0.5, 0.0, Angle()), kTime, "base_link", "radar"));
  // Two metres to the left of a plate that faces left: two metres behind it.
  const auto laser = tree.find("base_link", "laser");
  ASSERT_TRUE(laser);
  EXPECT_NEAR(laser->translation.x, -1.0, 1e-12);
  EXPECT_NEAR(laser->translation.y, 0.0, 1e-12);
  EXPECT_NEAR(tree.find("radar", "laser")->translation.x, -1.5, 1e-12);
  EXPECT_NEAR(tree.find("laser", "laser")->rotation.w, 1.0, 0.0);
  EXPECT_THAT(why(tree.find("base_link", "camera")),
              HasSubstr("there are plate -> laser, base_link -> plate"));
  tree.add(ros::transform_of(SE2d(), kTime, "laser", "base_link"));  // a cycle terminates
  EXPECT_FALSE(tree.find("base_link", "camera"));
}

}  // namespace
}  // namespace wayfare
