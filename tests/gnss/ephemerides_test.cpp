#include <wayfare/gnss/ephemerides.hpp>

#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sky.hpp"

namespace wayfare {
namespace {

using std::chrono::hours;
using std::chrono::seconds;
using ::testing::HasSubstr;

KeplerianEphemeris message(GnssSystem system, int number, Time<GpsClock> toe, int issue = 0) {
  KeplerianEphemeris k = testing::sky_message(system, number);
  k.toe = k.toc = toe;
  k.issue = issue;
  return k;
}

int issue_of(const Ephemeris* e) { return e ? std::get<KeplerianEphemeris>(*e).issue : -1; }

// Every second hour across the end of a week, added out of order, against brute force.
TEST(Ephemerides, NearestWorksAcrossTheEndOfTheWeek) {
  const SatelliteId satellite{GnssSystem::gps, 5};
  const Time<GpsClock> end_of_week = gps_time(2101, Duration(0));
  Ephemerides all;
  for (const int h : {-2, 4, -6, 0, 2, -4})
    ASSERT_TRUE(all.add(message(GnssSystem::gps, 5, end_of_week + hours(h), h + 100)));
  EXPECT_EQ(all.size(), 6U);
  for (int minutes = -600; minutes <= 600; minutes += 7) {
    const Time<GpsClock> t = end_of_week + std::chrono::minutes(minutes);
    int want = 0;
    Duration least = Duration::max();
    for (const Ephemeris& e : all.of(satellite)) {
      const Duration away = std::chrono::abs(reference_time(e) - t);
      if (away < least) least = away, want = issue_of(&e);
    }
    EXPECT_EQ(issue_of(all.nearest(satellite, t)), want) << minutes;
  }
  const auto& list = all.of(satellite);
  for (std::size_t i = 1; i < list.size(); ++i)
    EXPECT_LT(reference_time(list[i - 1]), reference_time(list[i]));
}

// Two messages with one time of week, a ten-bit roll-over apart: each is valid at its own time.
TEST(Ephemerides, DistinguishesWeekRollOvers) {
  Ephemerides all;
  const Time<GpsClock> now = gps_time(2100, hours(30)), then = gps_time(2100 - 1024, hours(30));
  ASSERT_TRUE(all.add(message(GnssSystem::gps, 5, now, 1)));
  ASSERT_TRUE(all.add(message(GnssSystem::gps, 5, then, 2)));
  EXPECT_EQ(all.size(), 2U);
  EXPECT_EQ(issue_of(all.nearest({GnssSystem::gps, 5}, now - hours(24))), 1);
  EXPECT_EQ(issue_of(all.nearest({GnssSystem::gps, 5}, then + hours(24))), 2);
}

TEST(Ephemerides, ReplacesARepeatedMessage) {
  Ephemerides all;
  const Time<GpsClock> t = testing::sky_time();
  ASSERT_TRUE(all.add(message(GnssSystem::gps, 5, t, 1)));
  ASSERT_TRUE(all.add(message(GnssSystem::gps, 5, t, 2)));
  EXPECT_EQ(all.size(), 1U);
  EXPECT_EQ(issue_of(all.nearest({GnssSystem::gps, 5}, t)), 2);
  EXPECT_EQ(all.nearest({GnssSystem::gps, 6}, t), nullptr);
  EXPECT_TRUE(all.of({GnssSystem::gps, 6}).empty());
}

TEST(Ephemerides, PrefersGalileoInav) {
  const Time<GpsClock> t = testing::sky_time();
  for (const bool e5a_first : {false, true}) {
    Ephemerides all;
    KeplerianEphemeris f = message(GnssSystem::galileo, 8, t, 1), i = f;
    f.clock_of_e5a = true;
    i.issue = 2;
    ASSERT_TRUE(all.add(e5a_first ? f : i));
    ASSERT_TRUE(all.add(e5a_first ? i : f));
    EXPECT_EQ(all.size(), 2U);
    EXPECT_EQ(issue_of(all.nearest({GnssSystem::galileo, 8}, t + seconds(60))), 2);
    EXPECT_EQ(issue_of(all.nearest({GnssSystem::galileo, 8}, t - seconds(60))), 2);
  }
}

TEST(Ephemerides, MergesMissingData) {
  Ephemerides a, b;
  ASSERT_TRUE(a.add(message(GnssSystem::gps, 1, testing::sky_time(), 1)));
  ASSERT_TRUE(b.add(message(GnssSystem::gps, 1, testing::sky_time(), 7)));
  ASSERT_TRUE(b.add(testing::sky_glonass(3)));
  a.leap_seconds = 18;
  b.leap_seconds = 19;
  b.gps_ionosphere = KlobucharModel{.alpha = {1e-8, 0, 0, 0}};
  a.add(b);
  EXPECT_EQ(a.size(), 2U);
  EXPECT_EQ(issue_of(a.nearest({GnssSystem::gps, 1}, testing::sky_time())), 7);
  EXPECT_EQ(a.leap_seconds, 18);
  ASSERT_TRUE(a.gps_ionosphere);
  EXPECT_EQ(a.gps_ionosphere->alpha[0], 1e-8);
  EXPECT_FALSE(a.beidou_ionosphere);
  EXPECT_EQ(a.satellites(),
            (std::vector<SatelliteId>{{GnssSystem::gps, 1}, {GnssSystem::glonass, 3}}));
}

struct BadMessage {
  const char* message;
  void (*spoil)(KeplerianEphemeris&);
};

TEST(Ephemerides, RejectsInvalidOrbits) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  static constexpr double kNanCopy = kNan;
  const BadMessage bad[] = {
      {"not finite", [](auto& k) { k.mean_anomaly_rad = kNanCopy; }},
      {"not finite", [](auto& k) { k.group_delay_s[1] = INFINITY; }},
      {"orbit's size", [](auto& k) { k.sqrt_semi_major_axis = 0.0; }},
      {"eccentricity", [](auto& k) { k.eccentricity = 0.99; }},
      {"eccentricity", [](auto& k) { k.eccentricity = -1e-9; }},
      {"correction", [](auto& k) { k.crs_m = 1e6; }},
      {"angle is", [](auto& k) { k.inclination_rad = 1e3; }},
      {"rate", [](auto& k) { k.ascending_node_rate_radps = 1.0; }},
      {"clock", [](auto& k) { k.clock_bias_s = 10.0; }},
      {"no such message", [](auto& k) { k.satellite.system = GnssSystem::glonass; }}};
  Ephemerides all;
  ASSERT_TRUE(all.add(message(GnssSystem::gps, 5, testing::sky_time(), 1)));
  for (const BadMessage& b : bad) {
    KeplerianEphemeris k = message(GnssSystem::gps, 5, testing::sky_time(), 2);
    b.spoil(k);
    const auto added = all.add(k);
    ASSERT_FALSE(added) << b.message;
    EXPECT_THAT(added.error().message, HasSubstr(b.message));
  }
  GlonassEphemeris g = testing::sky_glonass(3);
  g.channel = 14;
  EXPECT_THAT(all.add(g).error().message, HasSubstr("channel"));
  g = testing::sky_glonass(3);
  g.position_m *= 2.0;
  EXPECT_THAT(all.add(g).error().message, HasSubstr("not that of a GLONASS"));
  EXPECT_EQ(all.size(), 1U);
  EXPECT_EQ(all.satellites().size(), 1U);
  EXPECT_EQ(issue_of(all.nearest({GnssSystem::gps, 5}, testing::sky_time())), 1);
}

}  // namespace
}  // namespace wayfare
