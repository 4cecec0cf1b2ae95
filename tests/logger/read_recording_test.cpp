#include <wayfare/logger/messages.hpp>

#include <unistd.h>

#include <filesystem>

#include <gmock/gmock.h>

#include <wayfare/io/mcap.hpp>

namespace wayfare::logger {
namespace {

using ::testing::HasSubstr;

LogTime at(int ms) { return LogTime::from_nanoseconds(1'000'000LL * ms); }

class ReadRecording : public ::testing::Test {
 protected:
  /// A recording with samples of two units and one scan of a laser.
  void SetUp() override {
    path_ = (std::filesystem::temp_directory_path() /
             ("wayfare_" + std::to_string(::getpid()) + ".mcap"))
                .string();
    auto writer = io::McapWriter::create(path_, {}, {.existing = io::Existing::replace});
    ASSERT_TRUE(writer);
    const auto channel = [&](const char* topic, const MessageSchema& schema) {
      const auto id =
          writer->add_schema(std::string(schema.name), "jsonschema", std::string(schema.json));
      return *writer->add_channel(topic, "json", *id);
    };
    const auto put = [&](std::uint16_t id, int ms, const std::string& json) {
      EXPECT_TRUE(writer->write(id, at(ms), at(ms), json));
    };
    const auto left = channel("/left", imu_schema()), right = channel("/right", imu_schema());
    const auto laser = channel("/laser", laser_scan_schema());
    for (int i = 0; i < 5; ++i) {
      put(left, 10 * i, imu_json({at(10 * i), {0.1 * i, 0, 0}, {0, 0, 9.8}, {20, 0, 40}}, "l"));
      put(right, 10 * i + 1, imu_json({at(10 * i + 1), {0, 1, 0}, {0, 0, 9.8}, {20, 0, 40}}, "r"));
    }
    LaserScan scan;
    scan.time = at(7);
    scan.first_bearing = Angle::radians(-1);
    scan.bearing_step = Angle::radians(0.5);
    scan.max_range_m = 10;
    scan.ranges_m = {1, 2, 3, 4, 5};
    put(laser, 7, laser_scan_json(scan, "laser"));
    put(left, 60, "{\"not\": \"a sample\"}");
    ASSERT_TRUE(writer->close());
  }
  void TearDown() override { std::filesystem::remove(path_); }

  std::string path_;
};

TEST_F(ReadRecording, ReadsTheNamedUnitAndListsSeveral) {
  const auto left = read_marg_recording(path_, "/left");
  ASSERT_TRUE(left);
  ASSERT_EQ(left->samples.size(), 5U);
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(left->samples[static_cast<std::size_t>(i)].time, at(10 * i));
    EXPECT_EQ(left->samples[static_cast<std::size_t>(i)].angular_rate_radps.x(), 0.1 * i);
  }
  EXPECT_EQ(left->problems.count(), 1U) << "the message that is no sample";
  const auto either = read_marg_recording(path_);
  ASSERT_FALSE(either);
  EXPECT_THAT(either.error().to_string(), HasSubstr("/left"));
  EXPECT_THAT(either.error().to_string(), HasSubstr("/right"));
  EXPECT_FALSE(read_marg_recording(path_, "/middle"));
  EXPECT_FALSE(read_marg_recording(path_ + ".none"));
}

TEST_F(ReadRecording, ReadsTheRobotsScans) {
  const auto robot = read_robot_recording(path_);
  ASSERT_TRUE(robot);
  EXPECT_EQ(robot->scan_topic, "/laser");
  EXPECT_EQ(robot->radar_topic, "");
  ASSERT_EQ(robot->recording.scans.size(), 1U);
  EXPECT_EQ(robot->recording.scans[0].time, at(7));
  EXPECT_THAT(robot->recording.scans[0].ranges_m, ::testing::ElementsAre(1, 2, 3, 4, 5));
}

TEST(ReadRecordingName, EndsInMcap) {
  EXPECT_TRUE(is_recording("walk/one.mcap"));
  EXPECT_FALSE(is_recording("one.mcap.txt"));
  EXPECT_FALSE(is_recording("mcap"));
}

}  // namespace
}  // namespace wayfare::logger
