// Logs whose time stamps cannot be used as they are.

#include <wayfare/io/carmen.hpp>

#include <cstddef>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "support.hpp"

namespace wayfare::io {
namespace {

using ::testing::HasSubstr;

constexpr int kClockScans = 60;

/// Stamps of scan and odometry line `i` of the undamaged log: one each 0.2 s, from 1000 s.
double stamp_s(int i) { return 1000.0 + 0.2 * i; }

struct StampDamage {
  std::function<std::string(int)> sensor = [](int i) { return std::to_string(stamp_s(i)); };
  std::function<std::string(int)> logger = [](int) { return std::string("0"); };
  bool scan_has_pose = true;
};

/// A robot that drives 0.1 m from each scan to the next. An ODOM line comes before each scan.
std::string damaged_log(const StampDamage& damage) {
  std::string text;
  for (int i = 0; i < kClockScans; ++i) {
    const std::string x = std::to_string(0.1 * i);
    const std::string times = damage.sensor(i) + " host " + damage.logger(i) + "\n";
    text += "ODOM " + x + " 0 0 0 0 0 " + times;
    // The first range makes each scan differ from the one before.
    const std::string ranges = " 3 " + std::to_string(1.0 + 0.01 * i) + " 2 3 ";
    if (damage.scan_has_pose) {
      text += "FLASER" + ranges + x + " 0 0 " + x + " 0 0 " + times;
    } else {
      text += "RAWLASER1 0 -1.57 3.14 1.57 80 0.01 0" + ranges + "0 " + times;
    }
  }
  return text;
}

CarmenLog log_of(const std::string& text) {
  Result<CarmenLog> log = parse_carmen(text, "test.log");
  EXPECT_TRUE(log) << log.error().to_string();
  return log.value_or(CarmenLog{});
}

/// All scans are there, in order of time, and the odometry at each scan's time is its pose.
void expect_whole(const CarmenLog& log, ClockState clock, const char* reason,
                  double tolerance_m = 1e-9) {
  EXPECT_EQ(log.statistics.clock, clock);
  ASSERT_EQ(log.recording.scans.size(), std::size_t{kClockScans});
  EXPECT_THAT(log.statistics.clock_reason, HasSubstr(reason));
  EXPECT_TRUE(log.problems.empty());
  const Trajectory odometry = as_trajectory(log.recording.odometry);
  for (std::size_t i = 0; i < log.recording.scans.size(); ++i) {
    const LaserScan& scan = log.recording.scans[i];
    EXPECT_FLOAT_EQ(scan.ranges_m[0], 1.0F + 0.01F * static_cast<float>(i));
    if (i > 0) {
      ASSERT_GE(scan.time, log.recording.scans[i - 1].time) << i;
    }
    const auto pose = pose_at(odometry, scan.time, {.largest_gap = from_seconds(5)});
    ASSERT_TRUE(pose) << i;
    EXPECT_NEAR(pose->x(), 0.1 * static_cast<double>(i), tolerance_m) << i;
  }
}

double scans_last_s(const CarmenLog& log) {
  return to_seconds(log.recording.scans.back().time - log.recording.scans.front().time);
}

TEST(CarmenClock, ConstantStampsNumberTheScans) {
  for (const char* value : {"0", "1211.686316", "4.29497e+09"}) {
    for (const bool posed : {true, false}) {
      StampDamage damage{.sensor = [value](int) { return std::string(value); },
                         .scan_has_pose = posed};
      const CarmenLog log = log_of(damaged_log(damage));
      expect_whole(log, ClockState::numbered, "time stamps cannot be used: all are");
      EXPECT_NEAR(scans_last_s(log), 0.1 * (kClockScans - 1), 1e-9);  // the default period
    }
  }
}

TEST(CarmenClock, DecreasingStampsGiveTheRate) {
  for (const bool posed : {true, false}) {
    const CarmenLog log = log_of(damaged_log(
        {.sensor = [](int i) { return std::to_string(stamp_s(-i)); }, .scan_has_pose = posed}));
    expect_whole(log, ClockState::numbered, "they run backwards");
    EXPECT_NEAR(scans_last_s(log), 0.2 * (kClockScans - 1), 1e-6);
  }
}

TEST(CarmenClock, LoggerTimesReplaceUselessStamps) {
  const CarmenLog log =
      log_of(damaged_log({.sensor = [](int) { return std::string("0"); },
                          .logger = [](int i) { return std::to_string(5.0 + 0.25 * i); }}));
  expect_whole(log, ClockState::logger, "the logger's times are used");
  EXPECT_NEAR(scans_last_s(log), 0.25 * (kClockScans - 1), 1e-9);
}

TEST(CarmenClock, AClockThatOverflowsContinues) {
  // Milliseconds in 32 bits wrap after 4294967.296 s.
  const auto wrapped = [](int i) {
    const double t = 4294967.296 - 5.0 + 0.2 * i;
    return std::to_string(t < 4294967.296 ? t : t - 4294967.296);
  };
  for (const bool posed : {true, false}) {
    const CarmenLog log = log_of(damaged_log({.sensor = wrapped, .scan_has_pose = posed}));
    expect_whole(log, ClockState::continued, "the clock was set back 1 times", 1e-6);
    EXPECT_NEAR(scans_last_s(log), 0.2 * (kClockScans - 1), 1e-3);
  }
}

TEST(CarmenClock, JitteringStampsAreInterpolated) {
  // Up to 0.2 s early or late at 0.2 s a scan: of eleven stamps, five are 0.04 s earlier than the
  // one before.
  const auto jittered = [](int i) {
    return std::to_string(stamp_s(i) + 0.2 * ((i * 5) % 11 - 5) / 5.0);
  };
  const CarmenLog log = log_of(damaged_log({.sensor = jittered}));
  expect_whole(log, ClockState::interpolated, "scans are out of order");
  EXPECT_NEAR(scans_last_s(log), 0.2 * (kClockScans - 1), 0.41);
}

TEST(CarmenClock, EqualStampsAreSpread) {
  // Whole seconds, of five scans each; the last second is not spread.
  const auto coarse = [](int i) { return std::to_string(1000 + i / 5); };
  const CarmenLog log = log_of(damaged_log({.sensor = coarse}));
  EXPECT_EQ(log.statistics.clock, ClockState::interpolated);
  ASSERT_EQ(log.recording.scans.size(), std::size_t{kClockScans});
  for (std::size_t i = 0; i + 5 < kClockScans; ++i)
    EXPECT_NEAR(to_seconds(log.recording.scans[i].time.since_epoch()),
                1000.0 + 0.2 * static_cast<double>(i), 1e-6);
}

TEST(CarmenClock, DecimalCommasAreRead) {
  std::string text = damaged_log({});
  for (char& c : text)
    if (c == '.') c = ',';
  const CarmenLog log = log_of(text), undamaged = log_of(damaged_log({}));
  EXPECT_TRUE(log.problems.empty());
  ASSERT_EQ(log.recording.scans.size(), std::size_t{kClockScans});
  for (std::size_t i = 0; i < kClockScans; ++i) {
    EXPECT_EQ(log.recording.scans[i].time, undamaged.recording.scans[i].time);
    EXPECT_EQ(log.recording.scans[i].ranges_m, undamaged.recording.scans[i].ranges_m);
  }
}

TEST(CarmenClock, OdometryWrittenLateIsSorted) {
  // Ten odometry lines at once, after the scans they belong to.
  std::string text, late;
  for (int i = 0; i < kClockScans; ++i) {
    const std::string x = std::to_string(0.1 * i), t = std::to_string(stamp_s(i));
    late = "ODOM " + x + " 0 0 0 0 0 " + t + " host 0\n" + late;
    text += "RAWLASER1 0 -1.57 3.14 1.57 80 0.01 0 3 1 2 3 0 " + t + " host 0\n";
    if (i % 10 == 9) text += std::exchange(late, {});
  }
  const CarmenLog log = log_of(text);
  EXPECT_TRUE(log.problems.empty());
  ASSERT_EQ(log.recording.odometry.size(), std::size_t{kClockScans});
  for (std::size_t i = 0; i < kClockScans; ++i)
    EXPECT_NEAR(log.recording.odometry[i].T_odom_base.raw().x(), 0.1 * static_cast<double>(i),
                1e-9);
}

TEST(CarmenClock, ASingleStampALittleOutOfOrderIsInterpolated) {
  // 0.45 s too early at 0.2 s a scan: before two others, so that it is the one to doubt.
  const auto late = [](int i) { return std::to_string(stamp_s(i) - (i == 40 ? 0.45 : 0.0)); };
  const std::string text = damaged_log({.sensor = late});
  const CarmenLog log = log_of(text);
  EXPECT_EQ(log.statistics.clock, ClockState::usable);
  EXPECT_THAT(log.statistics.clock_reason, HasSubstr("stamps of 1 of 60 scans are a little out"));
  ASSERT_EQ(log.recording.scans.size(), std::size_t{kClockScans});
  EXPECT_NEAR(to_seconds(log.recording.scans[40].time - log.recording.scans[39].time), 0.2, 1e-6);
  EXPECT_FLOAT_EQ(log.recording.scans[40].ranges_m[0], 1.4F);
}

TEST(CarmenClock, AnEarlierScanRepeatedLateIsDropped) {
  std::string text = damaged_log({});
  const auto line_of = [&](const char* begin) {
    const std::size_t at = text.find(begin);
    return std::pair(at, text.find('\n', at) + 1);
  };
  const auto [first, end] = line_of("FLASER 3 1.390000");
  const std::string repeated = text.substr(first, end - first);
  text.insert(line_of("FLASER 3 1.410000").second, repeated);
  const CarmenLog log = log_of(text);
  EXPECT_EQ(log.recording.scans.size(), std::size_t{kClockScans});
  EXPECT_EQ(log.statistics.clock_reason, "");
  EXPECT_EQ(log.problems.most_frequent(), "scan is out of order");
}

TEST(CarmenClock, AFewWrongStampsAreDroppedAsBefore) {
  const auto wrong = [](int i) {
    return i % 100 == 50 ? std::string("7") : std::to_string(stamp_s(i));
  };
  const CarmenLog log = log_of(damaged_log({.sensor = wrong}));
  EXPECT_EQ(log.statistics.clock, ClockState::usable);
  EXPECT_EQ(log.statistics.clock_reason, "");
  EXPECT_EQ(log.problems.most_frequent(), "odometry is out of order");
  EXPECT_EQ(log.recording.scans.size(), std::size_t{kClockScans - 1});
}

}  // namespace
}  // namespace wayfare::io
