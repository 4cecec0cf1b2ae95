// A real bag of a radar and an inertial unit, compared with its values as printed by ROS's own
// tools.

#include <algorithm>
#include <cstdio>
#include <map>
#include <sstream>

#include <gmock/gmock.h>

#include <wayfare/ros/convert.hpp>
#include <wayfare/ros/recording.hpp>

#include "io/support.hpp"

namespace wayfare {
namespace {

using ::testing::HasSubstr;

const std::string kFolder = WAYFARE_DATA_DIR "/radar/rio_demo/";
constexpr const char* kRadar = "/ti_mmwave/radar_scan_pcl";
constexpr const char* kImu = "/sensor_platform/imu";

class RioBag : public ::testing::Test {
 protected:
  void SetUp() override {
    WAYFARE_NEEDS_RECORDING(bag, "radar/rio_demo/ti_mmwave_rospkg_demo.bag.gz");
    const auto file = ros::RecordingFile::open(bag);
    ASSERT_TRUE(file) << file.error().to_string();
    file_ = *file;
    ASSERT_TRUE(file_->problems().empty());
  }
  std::optional<ros::RecordingFile> file_;
};

std::vector<std::string> lines_of(const std::string& name) {
  std::istringstream text(io::read_file(kFolder + name)->bytes);
  std::vector<std::string> lines;
  for (std::string line; std::getline(text, line);) lines.push_back(line);
  return lines;
}

/// Seconds of a ROS time as computed by Python.
double seconds(LogTime time) {
  const std::int64_t ns = time.nanoseconds();
  const auto seconds = ns / 1'000'000'000;
  return static_cast<double>(seconds) + 1e-9 * static_cast<double>(ns % 1'000'000'000);
}

template <class... Values>
std::string printed(const char* format, Values... values) {
  char line[200];
  std::snprintf(line, sizeof line, format, values...);
  return line;
}

TEST_F(RioBag, HasTheRadarsPointsExactly) {
  const std::vector<std::string> lines = lines_of("radar_scans.csv.gz");
  std::size_t next = 1, scans = 0;
  file_->read({kRadar}, [&](const ros::RecordedMessage& m) {
    const auto cloud = ros::from_bytes<ros::PointCloud2>(m.data, m.topic.dialect);
    EXPECT_TRUE(cloud);
    const auto scan = ros::radar_scan_of(*cloud, m.received);
    EXPECT_TRUE(scan);
    ++scans;
    for (const RadarPoint& p : scan->points) {
      const std::string line = printed("%.6f,%u,%.5f,%.5f,%.5f,%.2f,%.4f", seconds(scan->time),
                                       cloud->header.seq, double(p.x_m), double(p.y_m),
                                       double(p.z_m), double(p.snr_db), double(p.doppler_m_s));
      EXPECT_EQ(line, next < lines.size() ? lines[next] : "no line left");
      ++next;
    }
    return next < lines.size() && !::testing::Test::HasFailure();
  });
  EXPECT_EQ(next, lines.size());
  EXPECT_EQ(scans, 412U);
}

TEST_F(RioBag, HasTheUnitsSamplesExactly) {
  const std::vector<std::string> lines = lines_of("imu.csv.gz");
  std::size_t next = 1;
  file_->read({kImu}, [&](const ros::RecordedMessage& m) {
    const auto imu = ros::from_bytes<ros::Imu>(m.data, m.topic.dialect);
    EXPECT_TRUE(imu);
    const auto sample = ros::imu_of(*imu, *ros::time_of(imu->header.stamp));
    EXPECT_TRUE(sample);
    const Eigen::Vector3d &w = sample->angular_rate_radps, &f = sample->specific_force_mps2;
    const std::string line =
        printed("%.6f,%.6f,%.6f,%.6f,%.6f,%.5f,%.5f,%.5f", seconds(m.received),
                seconds(sample->time), w.x(), w.y(), w.z(), f.x(), f.y(), f.z());
    EXPECT_EQ(line, next < lines.size() ? lines[next] : "no line left");
    return ++next < lines.size() && !::testing::Test::HasFailure();
  });
  EXPECT_EQ(next, lines.size());
}

/// The radar's driver set no stamp.
TEST_F(RioBag, ReportsThatTheRadarHasNoStamps) {
  const auto refused = ros::read_robot(*file_);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().to_string(), HasSubstr("stamp is zero: the sender set no time"));
  EXPECT_THAT(refused.error().to_string(), HasSubstr("all 412 messages"));
  ros::TopicNames names;
  names.stamps = ros::StampSource::received;
  const auto run = ros::read_robot(*file_, names);
  ASSERT_TRUE(run) << run.error().to_string();
  EXPECT_EQ(run->recording.radar.size(), 412U);
  EXPECT_EQ(run->radar_topic, kRadar);
  EXPECT_EQ(ros::read_marg(*file_)->samples.size(), 8270U);
}

}  // namespace
}  // namespace wayfare
