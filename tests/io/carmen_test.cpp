#include <wayfare/io/carmen.hpp>

#include <zlib.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <numbers>
#include <string>
#include <tuple>

#include "support.hpp"

namespace wayfare::io {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

CarmenLog parsed(const std::string& text, const CarmenOptions& options = {}) {
  Result<CarmenLog> log = parse_carmen(text, "test.log", options);
  EXPECT_TRUE(log) << log.error().to_string();
  return log.value_or(CarmenLog{});
}

/// An FLASER line of `n` beams with ranges of 1.5 m.
std::string flaser(int n, const std::string& time, const std::string& poses = "1 2 0.5 3 4 0.25") {
  std::string line = "FLASER " + std::to_string(n);
  for (int i = 0; i < n; ++i) line += " 1.5";
  return line + " " + poses + " " + time + " host 0.5\n";
}

TEST(Carmen, ReadsAScanWithItsPosesAndTime) {
  const CarmenLog log = parsed(
      "# a comment\n"
      "FLASER 4 0.5 1 2.25 81.83 1 2 0.5 3 4 0.25 976052857.137530 nohost 12.5\n");
  ASSERT_EQ(log.recording.scans.size(), 1U);
  const LaserScan& scan = log.recording.scans[0];
  EXPECT_EQ(scan.time.nanoseconds(), 976052857137530000);
  EXPECT_THAT(scan.ranges_m, ElementsAre(0.5F, 1.0F, 2.25F, 81.83F));
  EXPECT_TRUE(scan.returned(2));
  EXPECT_FALSE(scan.returned(3));  // what a SICK writes for no return
  EXPECT_NEAR(scan.first_bearing.degrees(), -90.0, 1e-12);
  EXPECT_NEAR(scan.bearing_step.degrees(), 45.0, 1e-12);
  ASSERT_EQ(log.reported_poses.size(), 1U);
  EXPECT_EQ(log.reported_poses[0].T_map_base.raw().y(), 2.0);
  // Without ODOM lines the odometry is the scan's own.
  ASSERT_EQ(log.recording.odometry.size(), 1U);
  EXPECT_EQ(log.recording.odometry[0].T_odom_base.raw().x(), 3.0);
  EXPECT_NEAR(log.recording.odometry[0].T_odom_base.raw().heading().radians(), 0.25, 1e-15);
  EXPECT_EQ(log.statistics.odometry_source, OdometrySource::scan_fields);
  EXPECT_TRUE(log.problems.empty());
}

TEST(Carmen, FieldOfViewByNumberOfBeams) {
  // beams, PARAM lines, first bearing and step in degrees
  const std::string narrow = "PARAM laser_frontlaser_fov 100\n";
  const std::string fine = "PARAM laser_frontlaser_resolution 0.25\n";
  const std::tuple<int, std::string, double, double> cases[] = {
      {180, "", -90, 1},        {181, "", -90, 1},        {360, "", -90, 0.5},
      {361, "", -90, 0.5},      {180, fine, -90, 1},      {720, "", -90, 0.25},
      {721, "", -90, 0.25},     {401, narrow, -50, 0.25}, {401, narrow + fine, -50, 0.25},
      {541, fine, -67.5, 0.25}, {1, "", 0, 180},
  };
  for (const auto& [n, parameters, first, step] : cases) {
    const CarmenLog log = parsed(parameters + flaser(n, "1"));
    ASSERT_EQ(log.recording.scans.size(), 1U);
    EXPECT_NEAR(log.recording.scans[0].first_bearing.degrees(), first, 1e-9) << n << parameters;
    EXPECT_NEAR(log.recording.scans[0].bearing_step.degrees(), step, 1e-9) << n << parameters;
  }
}

TEST(Carmen, RobotLaserHasItsOwnGeometry) {
  const CarmenLog log = parsed(
      "ROBOTLASER1 4 -2.0 4.0 1.0 20.0 0.01 0 5 1 2 3 4 25 2 7 8 "
      "1.2 0 0 1 0 0 0.1 0.2 0.3 0.4 1e6 100.25 host 0.25\n"
      "ROBOTLASER1 4 -2.0 4.0 1.0 20.0 0.01 0 5 1 2 3 4 25 0 "
      "1 1.2 1.5707963 1 1 1.5707963 0.1 0.2 0.3 0.4 1e6 100.5 host 0.5\n"
      "ROBOTLASER2 4 -2.0 4.0 1.0 20.0 0.01 0 2 1 2 0 "
      "0 0 0 0 0 0 0.1 0.2 0.3 0.4 1e6 100.6 host 0.5\n");
  ASSERT_EQ(log.recording.scans.size(), 2U);
  const LaserScan& scan = log.recording.scans[0];
  EXPECT_EQ(scan.first_bearing.radians(), -2.0);
  EXPECT_EQ(scan.bearing_step.radians(), 1.0);
  EXPECT_TRUE(scan.returned(3));
  EXPECT_FALSE(scan.returned(4));  // 25 m on a laser of 20 m
  EXPECT_EQ(log.rear_scans.size(), 1U);
  // In both lines the laser is 0.2 m ahead of the robot.
  EXPECT_NEAR(log.recording.T_base_laser.raw().x(), 0.2, 1e-6);
  EXPECT_NEAR(log.recording.T_base_laser.raw().y(), 0.0, 1e-6);
  EXPECT_EQ(log.recording.odometry.size(), 2U);
}

TEST(Carmen, RawLaserAndOdomLines) {
  const CarmenLog log = parsed(
      "ODOM 0 0 0 0 0 0 1.0 host 0\n"
      "RAWLASER1 0 -1.57 3.14 0.0174533 80 0.01 0 3 1 2 3 0 1.5 host 0\n"
      "ODOM 1 0 0.1 0 0 0 2.0 host 1\n"
      "RAWLASER1 0 -1.57 3.14 0.0174533 80 0.01 0 3 1 2 3 0 2.5 host 0\n"
      "SYNC thing\nNEFF 1 2 3\nSYNC again\n");
  EXPECT_EQ(log.recording.scans.size(), 2U);
  EXPECT_EQ(log.recording.odometry.size(), 2U);
  EXPECT_TRUE(log.reported_poses.empty());
  EXPECT_EQ(log.statistics.odometry_source, OdometrySource::odom_lines);
  EXPECT_EQ(log.statistics.other.at("SYNC"), 2U);
  EXPECT_EQ(log.statistics.other.at("NEFF"), 1U);
}

TEST(Carmen, OdomLinesThatCoverLittleAreReplacedByTheScansOwn) {
  std::string text = "ODOM 0 0 0 0 0 0 0 host 0\nODOM 0 0 0 0 0 0 1 host 0\n";
  for (int i = 0; i < 10; ++i) text += flaser(3, std::to_string(i));
  EXPECT_EQ(parsed(text).statistics.odometry_source, OdometrySource::scan_fields);
  text += "ODOM 0 0 0 0 0 0 5 host 0\n";
  EXPECT_EQ(parsed(text).statistics.odometry_source, OdometrySource::odom_lines);
}

TEST(Carmen, PairsWithoutTimeAreATenthOfASecondApart) {
  const CarmenLog log = parsed(
      "Odometry 1 2 0.5\nLaser 2 1 2\n"
      "Odometry 2 2 0.5\nLaser 2 1 x\n"  // dropped, but its time passes
      "Odometry 3 2 0.5\nLaser 2 1 2\n");
  ASSERT_EQ(log.recording.scans.size(), 2U);
  EXPECT_EQ(log.statistics.clock, ClockState::numbered);
  EXPECT_EQ(log.recording.scans[1].time.nanoseconds(), 200000000);
  ASSERT_EQ(log.recording.odometry.size(), 3U);
  EXPECT_EQ(log.recording.odometry[1].time.nanoseconds(), 100000000);
  EXPECT_EQ(log.recording.odometry[1].T_odom_base.raw().x(), 2.0);
  ASSERT_EQ(log.problems.count(), 1U);
  EXPECT_EQ(log.problems.first()[0].line, 4U);
}

TEST(Carmen, ParametersSetTheMounting) {
  const CarmenLog log = parsed(
      "PARAM robot_frontlaser_offset 0.3 nohost 0\n"
      "PARAM laser_frontlaser_maxrange 12\n" +
      flaser(5, "1"));
  EXPECT_EQ(log.recording.T_base_laser.raw().x(), 0.3);
  EXPECT_EQ(log.recording.scans[0].max_range_m, 12.0F);
}

TEST(Carmen, ReportsMalformedLinesByNumberAndContinues) {
  const std::string most = std::to_string(std::numeric_limits<std::size_t>::max());
  const std::pair<std::string, std::string> cases[] = {
      {"FLASER 0 1 2 3 1 2 3 4 host 5", "no beams"},
      {"FLASER -3 1 2 3 1 2 3 4 host 5", "number of ranges, found '-3'"},
      {"FLASER", "number of ranges"},
      {"FLASER " + most + " 1 2", "the line ends after 2 of " + most + " ranges"},
      {"FLASER 3 1 1", "the line ends after 2 of 3 ranges"},
      {"FLASER 3 1 1 1e 0 0 0 0 0 0 5 host 0", "range 3 of 3 is not a number: '1e'"},
      {"FLASER 3 1 1 \x01\xff 0 0 0 0 0 0 5 host 0", "range 3 of 3 is not a number: '..'"},
      {"FLASER 3 1 1 1 0 nan 0 0 0 0 5 host 0", "not finite: 'nan'"},
      {"FLASER 3 1 1 1 0 0 0 0 0 0 inf host 0", "not a time stamp: 'inf'"},
      {"FLASER 3 1 1 1 0 0 0 0 0 0 9e9 host 0", "not a time stamp: '9e9'"},  // 285 years
      {"FLASER 4 1 1 1 0 0 0 0 0 0 5 host 0", "not a time stamp: 'host'"},   // one beam too few
      {"FLASER 2 1 1 1 0 0 0 0 0 0 5 host 0", "logger time: 'host'"},        // one too many
      {"FLASER 2 1 1 1 0 0 0 0 0 0 5", "more fields"},
      {"FLASER 3 1 1 1 0 0 0 0 0 0 5 host 0 9", "more fields"},
      {"ODOM 1 2 3", "3 of 6 numbers"},
      {"ODOM 1 2 x 0 0 0 5 host 5", "not a number: 'x'"},
      {"ROBOTLASER1 0 -1 2 0 0 0 0 1 1 0", "the line ends where"},
      {"ROBOTLASER1 0 -1 0 0 80 0 0 2 1 1 0 0 0 0 0 0 0 0 0 0 0 0 5 host 0", "are invalid"},
      {"ROBOTLASER1 0 -1 2 1 80 0 0 2 1 1 9 0 0 0", "within the remissions"},
      {"PARAM robot", "PARAM without"},
      {std::string("\0\0\x7f", 3), "unreadable bytes"},
      {"Odometry 1 2", "2 of 3 numbers"},
  };
  for (const auto& [line, message] : cases) {
    const CarmenLog log = parsed(flaser(3, "1") + line + "\n" + flaser(3, "9"));
    EXPECT_EQ(log.recording.scans.size(), 2U) << line;
    ASSERT_EQ(log.problems.count(), 1U) << line;
    EXPECT_EQ(log.problems.first()[0].line, 2U) << line;
    EXPECT_EQ(log.statistics.skipped_lines, 1U) << line;
    EXPECT_THAT(log.problems.first()[0].to_string(), HasSubstr(message));
    EXPECT_THAT(log.problems.first()[0].to_string(), ::testing::StartsWith("test.log:2: "));
  }
}

TEST(Carmen, NonFiniteOrNegativeRangesAreNoReturns) {
  const CarmenLog log =
      parsed("FLASER 6 1 nan -1 inf 1.#QNAN 2 0 0 0 0 0 0 5 host 0\n" + flaser(3, "6"));
  ASSERT_EQ(log.recording.scans.size(), 2U);
  const LaserScan& scan = log.recording.scans[0];
  std::string returned;
  for (std::size_t i = 0; i < 6; ++i) returned += scan.returned(i) ? '1' : '0';
  EXPECT_EQ(returned, "100001");
  EXPECT_EQ(log.statistics.invalid_ranges, 4U);
  EXPECT_THAT(log.problems.first()[0].to_string(), HasSubstr("test.log:1: 4 of 6 ranges"));
}

TEST(Carmen, ScansOutOfOrderAreReportedAndTheLargestOrderedSetKept) {
  // One stamp far ahead must not drop all lines after it.
  const CarmenLog log = parsed(flaser(3, "1") + flaser(3, "99999") + flaser(4, "2") +
                               flaser(4, "3") + flaser(5, "1.5") + flaser(6, "3"));
  std::vector<std::int64_t> seconds;
  for (const LaserScan& scan : log.recording.scans)
    seconds.push_back(scan.time.nanoseconds() / 1000000000);
  EXPECT_THAT(seconds, ElementsAre(1, 2, 3, 3));
  ASSERT_EQ(log.problems.count(), 2U);
  EXPECT_THAT(log.problems.first()[0].to_string(),
              HasSubstr("test.log:2: scan is out of order: time stamp 99999.000000000 s"));
  EXPECT_THAT(log.problems.first()[1].to_string(),
              HasSubstr("test.log:5: scan is out of order: time stamp 1.500000000 s after 3.0"));
}

TEST(Carmen, RepeatedScanIsReported) {
  const CarmenLog log = parsed(flaser(3, "1") + flaser(3, "2") + flaser(3, "2"));
  EXPECT_EQ(log.recording.scans.size(), 2U);
  EXPECT_THAT(log.problems.first()[0].to_string(), HasSubstr("3: repeats the scan of line 2"));
}

TEST(Carmen, TruncatedLastLine) {
  const std::string whole = flaser(3, "1") + flaser(3, "2");
  // A cut within the second line drops that line or nothing; it never changes the time.
  for (std::size_t size = flaser(3, "1").size(); size < whole.size(); ++size) {
    const CarmenLog log = parsed(whole.substr(0, size));
    if (log.recording.scans.size() == 2) {
      EXPECT_EQ(log.recording.scans[1].time.nanoseconds(), 2000000000);
      continue;
    }
    const bool nothing_left = size <= flaser(3, "1").size() + 6;
    if (!nothing_left) {
      ASSERT_EQ(log.problems.count(), 1U) << size;
      EXPECT_THAT(log.problems.first()[0].to_string(), HasSubstr("2: the last line is cut off"));
    }
  }
}

TEST(Carmen, CommonVariants) {
  std::string text = "\xef\xbb\xbf";  // byte order mark
  text += flaser(3, "1");
  text += "FLASER 3 1 1 1 0 0 0 0 0 0 2\r\n";              // no host, DOS line end
  text += "  FLASER\t3 +1 1.e0 1 0 0 0 0 0 0 3.0 host\n";  // tabs, no logger time
  text += "\n   \n";
  text += "FLASER 3 1 1 1 0 0 0 0 0 0 1.23e+01 192.168.0.1 0.5\n";  // address as host
  const CarmenLog log = parsed(text);
  EXPECT_EQ(log.recording.scans.size(), 4U) << log.problems.first()[0].to_string();
  EXPECT_EQ(log.recording.scans.back().time.nanoseconds(), 12300000000);
  EXPECT_TRUE(log.problems.empty());
}

TEST(Carmen, FindsTheNoReturnValue) {
  // 100 scans of 181 beams at all distances up to 9 m, 6 % of the beams read 10 m exactly.
  std::string text;
  for (int k = 0; k < 100; ++k) {
    text += "FLASER 181";
    for (int i = 0; i < 181; ++i) {
      const int mm = 1000 + (k * 181 + i) * 7919 % 8000;
      text += ' ';
      text += i % 16 == 0 ? std::string("10.0") : std::to_string(mm / 1000.0);
    }
    text += " 0 0 0 0 0 0 " + std::to_string(k) + " host 0\n";
  }
  EXPECT_EQ(parsed(text).statistics.max_range_m, 10.0F);
  EXPECT_EQ(parsed(text, {.find_no_return_value = false}).statistics.max_range_m, 80.0F);
}

TEST(Carmen, NothingUsefulIsAnError) {
  for (const std::string& text :
       {std::string("\n"), std::string("ODOM 0 0 0 0 0 0 1 h 1\n"), std::string(1000, '\0'),
        std::string("FLASER 3 1 1\n"), std::string("hello world\n")}) {
    const Result<CarmenLog> log = parse_carmen(text, "test.log");
    ASSERT_FALSE(log);
    EXPECT_THAT(log.error().to_string(), HasSubstr("no usable laser scan"));
  }
  EXPECT_THAT(parse_carmen("FLASER 3 1 1\n", "test.log").error().to_string(),
              HasSubstr("test.log:1: no usable laser"));
  EXPECT_EQ(parse_carmen("", "test.log").error().to_string(), "test.log: is empty");
}

TEST(Carmen, NothingUsefulWithoutKeptProblemsIsTheSameError) {
  const Result<CarmenLog> log = parse_carmen("FLASER 3 1 1\n", "test.log", {.max_problems = 0});
  ASSERT_FALSE(log);
  EXPECT_THAT(log.error().to_string(), HasSubstr("no usable laser scan"));
}

TEST(Carmen, ProblemsAreCappedButCounted) {
  std::string text = flaser(3, "1");
  for (int i = 0; i < 500; ++i) text += "FLASER x\n";
  const CarmenLog log = parsed(text, {.max_problems = 7});
  EXPECT_EQ(log.problems.count(), 500U);
  EXPECT_EQ(log.problems.first().size(), 7U);
}

TEST(Carmen, MissingFileAndFolder) {
  EXPECT_THAT(read_carmen("/no/such/file").error().to_string(), HasSubstr("No such file"));
  EXPECT_THAT(read_carmen("/").error().to_string(), HasSubstr("folder"));
}

TEST(Carmen, RealLogs) {
  struct Expected {
    const char* name;
    std::size_t scans, beams, odometry, skipped;
    float max_range_m;
    std::int64_t first_ns;
  };
  const Expected logs[] = {
      {"intel.clf.gz", 4445, 180, 4445, 0, 80.0F, 976052857137530000},
      {"fr079.clf.gz", 4791, 360, 4791, 0, 80.0F, 1211686316000},
      {"loop5.log.gz", 551, 181, 551, 0, 8.183F, 0},
      // After each scan these two have an ODOM line of time 0, which is out of order.
      {"seattle-corrected.log.gz", 241, 361, 19070, 241, 80.0F, 1244180000000},
      {"fhw-corrected.log.gz", 488, 180, 13447, 488, 51.05F, 180030000000},
  };
  for (const Expected& expected : logs) {
    WAYFARE_NEEDS_RECORDING(path, std::string("slam2d/") + expected.name);
    const Result<CarmenLog> log = read_carmen(path);
    ASSERT_TRUE(log) << log.error().to_string();
    EXPECT_EQ(log->recording.scans.size(), expected.scans) << expected.name;
    for (const LaserScan& scan : log->recording.scans)
      ASSERT_EQ(scan.ranges_m.size(), expected.beams);
    EXPECT_EQ(log->recording.odometry.size(), expected.odometry) << expected.name;
    EXPECT_EQ(log->statistics.skipped_lines, expected.skipped) << expected.name;
    EXPECT_EQ(log->statistics.max_range_m, expected.max_range_m) << expected.name;
    EXPECT_EQ(log->recording.scans[0].time.nanoseconds(), expected.first_ns) << expected.name;
    EXPECT_EQ(log->reported_poses.size(), expected.scans) << expected.name;
    EXPECT_EQ(log->statistics.odometry_source, OdometrySource::odom_lines) << expected.name;
    EXPECT_TRUE(log->statistics.compressed);
  }
}

}  // namespace
}  // namespace wayfare::io
