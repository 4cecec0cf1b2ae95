#include <chrono>
#include <cstdint>
#include <limits>
#include <type_traits>

#include <gtest/gtest.h>

#include <wayfare/core/time.hpp>

namespace wayfare {
namespace {

using namespace std::chrono_literals;
using Limits = std::numeric_limits<std::int64_t>;

static_assert(!std::is_constructible_v<LogTime, double>);
static_assert(!std::is_constructible_v<LogTime, int>);
static_assert(!std::is_convertible_v<Time<GpsClock>, LogTime>);
static_assert(!std::is_convertible_v<Duration, LogTime>);
static_assert(LogTime::from_seconds(1.5).nanoseconds() == 1'500'000'000);
static_assert(sizeof(LogTime) == sizeof(std::int64_t));

// A Unix time of 2026 needs 61 bits of nanoseconds; a double has 53 and would be off by up to 128.
TEST(Time, NanosecondsAreExact) {
  const auto t = LogTime::from_nanoseconds(1'795'000'000'123'456'789);
  EXPECT_EQ((t + 1ns).nanoseconds(), 1'795'000'000'123'456'790);
  EXPECT_EQ((t + 1ns) - t, 1ns);
  EXPECT_EQ((t - 1h) - t, -1h);
  EXPECT_NE(t, t + 1ns);
}

TEST(Time, OrderIncludesNegativeTimes) {
  const auto early = LogTime::from_nanoseconds(-5), zero = LogTime(), late = zero + 1us;
  EXPECT_LT(early, zero);
  EXPECT_LT(zero, late);
  EXPECT_GE(late, late);
  EXPECT_EQ(late - early, 1005ns);
  EXPECT_EQ(early <=> late, std::strong_ordering::less);
}

TEST(Time, SecondsRoundToTheNearestNanosecondOnBothSides) {
  EXPECT_EQ(LogTime::from_seconds(0.1).nanoseconds(), 100'000'000);
  EXPECT_EQ(LogTime::from_seconds(-0.1).nanoseconds(), -100'000'000);
  EXPECT_EQ(LogTime::from_seconds(1.4e-9).nanoseconds(), 1);
  EXPECT_EQ(LogTime::from_seconds(1.6e-9).nanoseconds(), 2);
  EXPECT_EQ(LogTime::from_seconds(-1.4e-9).nanoseconds(), -1);
  EXPECT_EQ(LogTime::from_seconds(-1.6e-9).nanoseconds(), -2);
  // Adding one half and truncating would give one.
  EXPECT_EQ(LogTime::from_seconds(0.49999999999999994e-9).nanoseconds(), 0);
}

TEST(Time, SecondsBeyondTheRangeAreClamped) {
  EXPECT_EQ(LogTime::from_seconds(1e300).nanoseconds(), Limits::max());
  EXPECT_EQ(LogTime::from_seconds(-1e300).nanoseconds(), Limits::min());
  EXPECT_EQ(LogTime::from_seconds(std::numeric_limits<double>::infinity()).nanoseconds(),
            Limits::max());
  EXPECT_EQ(LogTime::from_seconds(0x1p63 * 1e-9).nanoseconds(), Limits::max());
}

TEST(Time, SecondsAndBack) {
  // 2⁵³ ns is about 104 days: up to there a double represents every nanosecond.
  for (std::int64_t ns = 1; ns < (std::int64_t{1} << 52); ns = ns * 3 + 1) {
    EXPECT_EQ(LogTime::from_seconds(LogTime::from_nanoseconds(ns).seconds()).nanoseconds(), ns);
    EXPECT_EQ(from_seconds(to_seconds(Duration(-ns))), Duration(-ns));
  }
}

}  // namespace
}  // namespace wayfare
