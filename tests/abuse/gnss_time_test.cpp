// Time scales at the limits of a time, and numbers of weeks that no receiver sends.

#include <array>
#include <cstdint>
#include <limits>
#include <tuple>

#include <gtest/gtest.h>

#include <wayfare/gnss/gps_time.hpp>

#include "abuse/abuse.hpp"

namespace wayfare {
namespace {

using namespace tests;
using std::chrono::seconds;

constexpr std::int64_t kFirst_ns = std::numeric_limits<std::int64_t>::min();
constexpr std::int64_t kLast_ns = std::numeric_limits<std::int64_t>::max();
constexpr std::array kLimits_ns = {kFirst_ns,
                                   kFirst_ns + 1,
                                   -std::int64_t{1},
                                   std::int64_t{0},
                                   std::int64_t{1'000'000'000'000'000'000},
                                   kLast_ns - 1,
                                   kLast_ns};

template <class Clock>
Time<Clock> at(std::int64_t ns) {
  return Time<Clock>::from_nanoseconds(ns);
}

TEST(GpsTimeAbuse, ConversionsAtTheLimitsOfTimeAreTheNearestInstants) {
  for (const std::int64_t ns : kLimits_ns) {
    SCOPED_TRACE(ns);
    // Offsets are far below a century: signs and order remain.
    EXPECT_EQ(to_gps(at<BeidouClock>(ns)).nanoseconds() > 0, ns > -1'000'000'000'000'000'000);
    EXPECT_LE(to_gps(at<GalileoClock>(ns)), at<GpsClock>(kLast_ns));
    EXPECT_LE(to_beidou(at<GpsClock>(ns)).nanoseconds(), ns);
    EXPECT_LE(to_galileo(at<GpsClock>(ns)).nanoseconds(), ns);
    EXPECT_LE(to_utc(at<GlonassClock>(ns)).nanoseconds(), ns);
    EXPECT_GE(to_glonass(at<UtcClock>(ns)).nanoseconds(), ns);
    EXPECT_GE(to_gps(at<UtcClock>(ns)).nanoseconds(), ns);
    EXPECT_LE(to_utc(at<GpsClock>(ns)).nanoseconds(), ns);
    EXPECT_EQ(gps_time(log_time(at<GpsClock>(ns))), at<GpsClock>(ns));
  }
  EXPECT_EQ(to_gps(at<UtcClock>(kLast_ns)), at<GpsClock>(kLast_ns));
  EXPECT_EQ(to_utc(at<GlonassClock>(kFirst_ns)), at<UtcClock>(kFirst_ns));
  EXPECT_EQ(to_gps(at<UtcClock>(kLast_ns), {}), at<GpsClock>(kLast_ns));  // without a table
  EXPECT_EQ(to_utc(at<GpsClock>(5), {}), at<UtcClock>(5));
}

TEST(GpsTimeAbuse, WeeksOfAnyNumber) {
  constexpr std::array kWeeks = {
      std::numeric_limits<int>::min(), -15251, -15250, -1, 0, 1, 15249, 15250, 15251,
      std::numeric_limits<int>::max()};
  Time<GpsClock> before = at<GpsClock>(kFirst_ns);
  for (const int week : kWeeks) {
    const Time<GpsClock> time = gps_time(week, std::chrono::hours(30));
    EXPECT_GE(time, before) << week;
    before = time;
    EXPECT_LE(std::abs(unrolled_week(week, gps_time(2051, seconds(0))) - 2051), 512) << week;
    EXPECT_GE(nearest_time_of_week(seconds(week), time), at<GpsClock>(kFirst_ns));
  }
  EXPECT_EQ(gps_time(std::numeric_limits<int>::max(), seconds(0)), at<GpsClock>(kLast_ns));
  EXPECT_EQ(gps_time(std::numeric_limits<int>::min(), seconds(0)), at<GpsClock>(kFirst_ns));
}

TEST(GpsTimeAbuse, WeekAndCalendarOfAnyInstantAreItsOwn) {
  for (const std::int64_t ns : kLimits_ns) {
    SCOPED_TRACE(ns);
    const WeekTime week = week_time(at<GpsClock>(ns));
    EXPECT_GE(week.of_week, Duration(0));
    EXPECT_LT(week.of_week, kGpsWeek);
    const CivilTime civil = civil_from_gps(at<GpsClock>(ns));
    EXPECT_TRUE(civil.month >= 1 && civil.month <= 12 && civil.day >= 1 && civil.day <= 31);
    EXPECT_TRUE(civil.hour >= 0 && civil.hour < 24 && civil.minute >= 0 && civil.minute < 60);
    EXPECT_TRUE(civil.of_minute >= Duration(0) && civil.of_minute < std::chrono::minutes(1));
    const auto again = gps_from_civil(civil);
    EXPECT_EQ(again.has_value(), civil.year >= 1980 && civil.year <= 2099);
    if (again) {
      EXPECT_EQ(again->nanoseconds(), ns);
    }
  }
}

TEST(GpsTimeAbuse, DatesThatDoNotExistAreNone) {
  constexpr int kLow = std::numeric_limits<int>::min(), kHigh = std::numeric_limits<int>::max();
  const CivilTime good{2024, 2, 29, 23, 59, seconds(60)};
  EXPECT_TRUE(gps_from_civil(good));
  for (int CivilTime::*field : {&CivilTime::year, &CivilTime::month, &CivilTime::day,
                                &CivilTime::hour, &CivilTime::minute}) {
    for (const int value : {kLow, -1, 10'000, kHigh}) {
      CivilTime bad = good;
      bad.*field = value;
      EXPECT_FALSE(gps_from_civil(bad)) << value;
      EXPECT_FALSE(utc_from_civil(bad)) << value;
      EXPECT_FALSE(beidou_from_civil(bad)) << value;
    }
  }
  for (const Duration of_minute :
       {Duration::min(), Duration(-1), Duration(seconds(61)), Duration::max()})
    EXPECT_FALSE(gps_from_civil({2024, 2, 29, 0, 0, of_minute}));
  EXPECT_FALSE(gps_from_civil({2023, 2, 29, 0, 0, {}}));
}

}  // namespace
}  // namespace wayfare
