#include <wayfare/gnss/gps_subframes.hpp>

#include <gtest/gtest.h>

#include "subframe_writer.hpp"

namespace wayfare {
namespace {

using tests::sample_ephemeris;
using tests::subframes_of;

std::optional<KeplerianEphemeris> collect(GpsSubframes& collector, const KeplerianEphemeris& sent,
                                          Time<GpsClock> near) {
  std::optional<KeplerianEphemeris> got;
  for (const GpsSubframe& words : subframes_of(sent))
    if (auto e = collector.add(sent.satellite.number, words, near)) got = e;
  return got;
}

TEST(GpsSubframes, OrbitAndClockReadBack) {
  const KeplerianEphemeris sent = sample_ephemeris();
  GpsSubframes collector;
  const auto got = collect(collector, sent, sent.toe - std::chrono::hours(1));
  ASSERT_TRUE(got);
  EXPECT_EQ(got->satellite, sent.satellite);
  EXPECT_EQ(got->toe, sent.toe);
  EXPECT_EQ(got->toc, sent.toc);
  EXPECT_EQ(got->issue, sent.issue);
  EXPECT_EQ(got->health, sent.health);
  for (const auto member :
       {&KeplerianEphemeris::sqrt_semi_major_axis, &KeplerianEphemeris::eccentricity,
        &KeplerianEphemeris::mean_anomaly_rad, &KeplerianEphemeris::mean_motion_difference_radps,
        &KeplerianEphemeris::inclination_rad, &KeplerianEphemeris::inclination_rate_radps,
        &KeplerianEphemeris::ascending_node_rad, &KeplerianEphemeris::ascending_node_rate_radps,
        &KeplerianEphemeris::argument_of_perigee_rad, &KeplerianEphemeris::cuc_rad,
        &KeplerianEphemeris::cus_rad, &KeplerianEphemeris::crc_m, &KeplerianEphemeris::crs_m,
        &KeplerianEphemeris::cic_rad, &KeplerianEphemeris::cis_rad,
        &KeplerianEphemeris::clock_bias_s, &KeplerianEphemeris::clock_drift,
        &KeplerianEphemeris::clock_drift_rate_per_s})
    EXPECT_DOUBLE_EQ((*got).*member, sent.*member);
  EXPECT_DOUBLE_EQ(got->group_delay_s[0], sent.group_delay_s[0]);
  EXPECT_FALSE(collect(collector, sent, sent.toe)) << "each issue once";
}

TEST(GpsSubframes, TheWeekIsThatNearTheReception) {
  const KeplerianEphemeris sent = sample_ephemeris();
  GpsSubframes collector;
  const auto got = collect(collector, sent, sent.toe - 1024 * kGpsWeek);
  ASSERT_TRUE(got);
  EXPECT_EQ(got->toe, sent.toe - 1024 * kGpsWeek);
}

TEST(GpsSubframes, MixedIssuesAndDamagedWordsGiveNothing) {
  const KeplerianEphemeris sent = sample_ephemeris();
  KeplerianEphemeris later = sent;
  later.issue = 84;
  const auto a = subframes_of(sent), b = subframes_of(later);
  GpsSubframes collector;
  EXPECT_FALSE(collector.add(17, a[0], sent.toe));
  EXPECT_FALSE(collector.add(17, a[1], sent.toe));
  EXPECT_FALSE(collector.add(17, b[2], sent.toe));
  EXPECT_FALSE(collector.add(33, a[2], sent.toe)) << "no such satellite";
  EXPECT_FALSE(collector.add(0, a[2], sent.toe));
  GpsSubframe damaged = a[2];
  damaged[0] ^= 0x800000U;
  EXPECT_FALSE(collector.add(17, damaged, sent.toe)) << "no preamble";
  EXPECT_TRUE(collector.add(17, a[2], sent.toe));
}

// The coefficients of the example in RINEX 3.05, table A8: 0.1211e-7, −0.7451e-8 …; 18 leap
// seconds.
TEST(GpsSubframes, IonosphereAndLeapSecondsOfPage18) {
  tests::SubframeWriter page(4, 100);
  page.put(1, 2).put(56, 6);
  for (const int alpha : {13, -1, -1, 1}) page.put(static_cast<std::uint8_t>(alpha), 8);
  for (const int beta : {44, -2, -1, 5}) page.put(static_cast<std::uint8_t>(beta), 8);
  page.put(0, 24 + 24 + 24);  // UTC parameters
  page.put(18, 8).put(0, 16).put(0, 24);
  GpsSubframes collector;
  EXPECT_FALSE(collector.add(1, page.words(), gps_time(2381, {})));
  ASSERT_TRUE(collector.ionosphere());
  EXPECT_NEAR(collector.ionosphere()->alpha[0], 0.1211e-7, 1e-11);
  EXPECT_NEAR(collector.ionosphere()->alpha[1], -0.7451e-8, 1e-12);
  EXPECT_NEAR(collector.ionosphere()->alpha[3], 0.5960e-7, 1e-11);
  EXPECT_DOUBLE_EQ(collector.ionosphere()->beta[0], 90112.0);
  EXPECT_DOUBLE_EQ(collector.ionosphere()->beta[1], -32768.0);
  EXPECT_EQ(collector.leap_seconds(), 18);
}

}  // namespace
}  // namespace wayfare
