// The GNSS/INS filter with starts, times and values at and beyond the border of what it accepts.

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/nav/gnss_ins.hpp>
#include <wayfare/nav/ins_filter.hpp>

#include <wayfare/testing/filter_laws.hpp>

#include "abuse/abuse.hpp"
#include "nav/gnss_ins_support.hpp"

namespace wayfare {
namespace {

using namespace tests;

const LogTime kFirst = LogTime() + Duration::min(), kLast = LogTime() + Duration::max();

/// Ten seconds of driving at 50 Hz, given start and ranges at 2 Hz.
struct Ride {
  Drive drive{.rest_s = 0.5};
  Simulated simulated = simulate(drive, 10.0, 0.02);
  std::vector<RangeEpoch> ranges = simulate_ranges(drive, simulated, 0.5, {}, 7);
  GnssInsStart start{simulated.truth.front(), 1.0, 0.1, 0.01, 0.05};

  /// Feeds readings and ranges of [from, to) s, shifted by `shift`.
  void feed(GnssIns& ins, double from_s, double to_s, Duration shift = Duration(0)) const {
    for (ImuSample s : simulated.imu) {
      if (s.time.seconds() < from_s || s.time.seconds() >= to_s) continue;
      for (RangeEpoch e : ranges)
        if (e.time == s.time) e.time += shift, static_cast<void>(ins.add(e));
      s.time += shift;
      static_cast<void>(ins.add(s));
    }
  }
  [[nodiscard]] GnssIns running(double to_s = 4.0) const {
    GnssIns ins{GnssInsOptions{}};
    ins.start(start);
    feed(ins, 0.0, to_s);
    return ins;
  }
};

bool notes(GnssIns& ins, const std::string& text) {
  const auto notices = ins.take_notices();
  return std::any_of(notices.begin(), notices.end(),
                     [&](const auto& n) { return n.text.find(text) != n.text.npos; });
}

void expect_sound(const GnssIns& ins) {
  ASSERT_TRUE(ins.started());
  const GnssInsEstimate e = ins.estimate();
  ASSERT_TRUE(e.nav.velocity_ned_mps.allFinite() && std::isfinite(e.nav.position.height_m));
  ASSERT_TRUE(
      std::isfinite(e.nav.position.latitude.radians() + e.nav.position.longitude.radians()));
  ASSERT_TRUE(
      testing::is_covariance(Eigen::MatrixXd(0.5 * (e.covariance + e.covariance.transpose()))));
  ASSERT_TRUE(ins.point().sigma.allFinite());
}

TEST(GnssInsAbuse, AStartThatIsNoneLeavesTheFilterAsItWas) {
  const Ride ride;
  std::vector<GnssInsStart> bad;
  for (const double x : {kNan, kInf, -kInf, kHuge, -1e9}) {
    for (int field = 0; field < 8; ++field) {
      GnssInsStart s = ride.start;
      if (field == 0) s.nav.position.latitude = Angle::radians(x);
      if (field == 1) s.nav.position.longitude = Angle::radians(x);
      if (field == 2) s.nav.position.height_m = x;
      if (field == 3) s.nav.velocity_ned_mps[1] = x;
      if (field == 4) s.position_sigma_m = x;
      if (field == 5) s.heading_sigma_rad = x;
      if (field == 6) s.gyro_bias_sigma_radps = x;
      if (field == 7) s.level_sigma_rad = std::isfinite(x) ? -1.0 : x;
      bad.push_back(s);
    }
  }
  bad.push_back(ride.start);
  bad.back().nav.position.latitude = Angle::degrees(90);
  GnssIns ins = ride.running();
  const auto before = ins.estimate().covariance;
  for (const GnssInsStart& s : bad) {
    GnssIns fresh{GnssInsOptions{}};
    fresh.start(s);
    EXPECT_TRUE(notes(fresh, "implausible"));
    ride.feed(fresh, 0.0, 0.2);
    EXPECT_FALSE(fresh.started());
    ins.start(s);
    ASSERT_TRUE(ins.started());
  }
  EXPECT_EQ(ins.estimate().covariance, before);
}

TEST(GnssInsAbuse, AStartLongBeforeTheReadingsIsNotUsed) {
  const Ride ride;
  for (const LogTime time : {kFirst, LogTime::from_seconds(-1e9), LogTime::from_seconds(-11.0)}) {
    GnssIns ins{GnssInsOptions{}};
    GnssInsStart start = ride.start;
    start.nav.time = time;
    ins.start(start);
    ride.feed(ins, 0.0, 0.2);
    EXPECT_FALSE(ins.started()) << time.seconds();
    EXPECT_TRUE(notes(ins, "too long before"));
    // Nor while readings have come already.
    ins.start(start);
    ride.feed(ins, 0.2, 0.4);
    EXPECT_FALSE(ins.started());
    ins.start(ride.start);
    ride.feed(ins, 0.4, 0.6);
    expect_sound(ins);
  }
  GnssIns ahead{GnssInsOptions{}};
  GnssInsStart start = ride.start;
  start.nav.time = kLast;
  ahead.start(start);
  ride.feed(ahead, 0.0, 1.0);
  EXPECT_FALSE(ahead.started());
  EXPECT_DEATH(static_cast<void>(ahead.estimate()), "the filter has started");
  EXPECT_DEATH(static_cast<void>(ahead.point()), "the filter has started");
}

TEST(GnssInsAbuse, WorksAtAnyTime) {
  const Ride ride;
  // 1e9 s, and the last ten seconds of time.
  for (const Duration shift :
       {from_seconds(1e9), from_seconds(-9e9), kLast - LogTime::from_seconds(10.0)}) {
    GnssIns here = ride.running(0.0), there = ride.running(0.0);
    here.start(ride.start);
    ride.feed(here, 0.0, 4.0);
    GnssInsStart start = ride.start;
    start.nav.time += shift;
    there.start(start);
    ride.feed(there, 0.0, 4.0, shift);
    expect_sound(there);
    EXPECT_LT(distance_m(here.estimate().nav, there.estimate().nav), 1e-6);
  }
}

TEST(GnssInsAbuse, OneReadingFromTheFutureDoesNotStopIt) {
  const Ride ride;
  for (const LogTime time : {kLast, LogTime::from_seconds(1e9), LogTime::from_seconds(20.0)}) {
    GnssIns ins = ride.running();
    ImuSample odd = ride.simulated.imu[201];
    odd.time = time;
    static_cast<void>(ins.add(odd));
    ride.feed(ins, 4.0, 10.0);
    EXPECT_TRUE(notes(ins, "set back")) << time.seconds();
    expect_sound(ins);
    EXPECT_LT(distance_m(ins.estimate().nav, ride.simulated.truth[499]), 20.0);
  }
}

TEST(GnssInsAbuse, ReadingsThatLeadOffTheEarthReinitialise) {
  const Ride ride;
  for (const double down : {4999.0, -4999.0}) {
    GnssIns ins = ride.running();
    ImuSample s = ride.simulated.imu[200];
    s.specific_force_mps2 = {0.0, 0.0, down};
    bool off = false;
    for (int i = 0; i < 6000 && !off; ++i) {
      s.time += std::chrono::milliseconds(50);
      ASSERT_TRUE(ins.add(s));
      off = !ins.started();
      if (!off && i % 100 == 0) {
        ASSERT_TRUE(ins.estimate().nav.velocity_ned_mps.allFinite());
      }
    }
    EXPECT_TRUE(off);
    EXPECT_TRUE(notes(ins, "off the Earth"));
  }
}

TEST(GnssInsAbuse, EpochsAtTheLimitsOfTimeAreRefused) {
  const Ride ride;
  GnssIns ins = ride.running();
  const auto before = ins.estimate().covariance;
  for (const LogTime time :
       {kFirst, kLast, LogTime::from_seconds(1e9), LogTime::from_seconds(-1e9)}) {
    RangeEpoch epoch = ride.ranges.back();
    epoch.time = time;
    EXPECT_FALSE(ins.add(epoch));
    GnssFix fix;
    fix.position = ride.drive.origin;
    fix.time = time;
    EXPECT_FALSE(ins.add(fix));
  }
  EXPECT_EQ(ins.estimate().covariance, before);
  ride.feed(ins, 4.0, 6.0);
  expect_sound(ins);
}

TEST(GnssInsAbuse, AFixWithoutVelocityIsNotStandstill) {
  // Turning steadily with fixes that have no velocity, then one with.
  GnssIns ins{GnssInsOptions{}};
  Drive drive{.rest_s = 0.0, .swing_rad = 0.0};
  const Simulated run = simulate(drive, 12.0, 0.02);
  GnssFix fix;
  for (std::size_t i = 0; i < run.imu.size(); ++i) {
    ImuSample s = run.imu[i];
    s.angular_rate_radps.z() += 0.05;  // a bias that must not be taken for one at rest
    ASSERT_TRUE(ins.add(s));
    if (i % 25 != 0) continue;
    fix.time = s.time;
    fix.position = run.truth[i].position;
    if (i > 500) fix.velocity_ned_mps = run.truth[i].velocity_ned_mps;
    static_cast<void>(ins.add(fix));
    if (ins.started()) break;
  }
  ASSERT_TRUE(ins.started());
  EXPECT_EQ(ins.estimate().gyro_bias_radps.norm(), 0.0);
  // The fix that started it is in the state, and not used again after another one.
  GnssFix next = fix;
  next.time += std::chrono::milliseconds(5);
  EXPECT_TRUE(ins.add(next));
  EXPECT_FALSE(ins.add(fix));
}

TEST(GnssInsAbuse, RunsOfNothingAreErrors) {
  const Ride ride;
  EXPECT_FALSE(run_gnss_ins({}, {}));
  EXPECT_FALSE(run_gnss_ins({ride.simulated.imu, {}, {}, {}}, {}));
  EXPECT_FALSE(run_gnss_ins({{}, ride.ranges, {}, ride.start}, {}));
  EXPECT_FALSE(run_gnss_ins({ride.simulated.imu, std::vector<RangeEpoch>(1), {}, {}}, {}));
  GnssInsStart start = ride.start;
  start.nav.position.height_m = kNan;
  EXPECT_FALSE(run_gnss_ins({ride.simulated.imu, {}, {}, start}, {}));
  // One reading, and the same a thousand times.
  EXPECT_TRUE(run_gnss_ins({{ride.simulated.imu[0]}, {}, {}, ride.start}, {}));
  const auto same = run_gnss_ins(
      {std::vector<ImuSample>(1000, ride.simulated.imu[0]), ride.ranges, {}, ride.start}, {});
  ASSERT_TRUE(same);
  EXPECT_EQ(same->points.size(), 1U);
  EXPECT_EQ(std::count_if(same->notices.begin(), same->notices.end(),
                          [](const auto& n) { return n.text.find("twice") != n.text.npos; }),
            999);
  // Backwards.
  auto reversed = ride.simulated.imu;
  std::reverse(reversed.begin(), reversed.end());
  const auto back = run_gnss_ins({reversed, ride.ranges, {}, ride.start}, {});
  EXPECT_TRUE(!back || back->points.size() < 10);
}

TEST(GnssInsAbuse, OptionsOfAnySizeEndInTime) {
  const Ride ride;
  GnssInsOptions o;
  o.max_imu_gap_s = 1e9;
  o.max_lateness_s = 1e9;
  GnssIns ins(o);
  GnssInsStart start = ride.start;
  start.nav.time = LogTime::from_seconds(-500.0);
  ins.start(start);
  ride.feed(ins, 0.0, 0.1);
  EXPECT_TRUE(!ins.started() || ins.estimate().nav.velocity_ned_mps.allFinite());
}

TEST(GnssInsAbuse, MovesWithItsPast) {
  const Ride ride;
  expect_move_semantics([&] { return ride.running(2.0); },
                        [&](GnssIns& ins) {
                          ride.feed(ins, 2.0, 3.0);
                          const auto p = ins.point();
                          return std::tuple(p.nav.position.height_m, p.nav.velocity_ned_mps.norm(),
                                            ins.take_innovations().size());
                        });
}

TEST(GnssInsAbuse, TwoInstancesInTwoThreads) {
  const Ride ride;
  const auto results = in_two_threads([&](int) {
    const GnssIns ins = ride.running();
    const auto e = ins.estimate();
    return std::tuple(e.nav.position.height_m, e.covariance.sum());
  });
  EXPECT_EQ(results[0], results[1]);
}

TEST(InsFilterAbuse, RangesThatAreNotNumbersAreRejected) {
  const Geodetic here{Angle::degrees(48.7), Angle::degrees(9.1), 300.0};
  using Filter = InsFilter<double, 1>;
  Filter filter(here, 0.0, {}, Filter::Square::Identity(), InsNoise<double>(ImuNoise{}, {}),
                {0.1, 0.2, 0.3});
  NavState at;
  at.position = here;
  const CorrectedRange good =
      range_to(sky(here, 4)[1], 1, at, {0.1, 0.2, 0.3}, Eigen::Vector3d::Zero());
  for (const double x : {kNan, kInf, -kInf, kHuge}) {
    CorrectedRange bad = good;
    bad.range_m = bad.range_rate_mps = x;
    EXPECT_FALSE(filter.update_range(bad, 1.0, 5.0).accepted);
    EXPECT_FALSE(filter.update_range(bad, 1.0, 5.0, 0).accepted);
    EXPECT_FALSE(filter.update_range_rate(bad, 1.0, 5.0).accepted);
    bad = good;
    bad.position_ecef_m[1] = x;
    EXPECT_FALSE(filter.update_range(bad, 1.0, 5.0).accepted);
    bad = good;
    bad.velocity_ecef_mps[1] = x;
    EXPECT_FALSE(filter.update_range_rate(bad, 1.0, 5.0).accepted);
    EXPECT_FALSE(filter.update_range(good, x, 5.0).accepted);  // its square overflows
  }
  EXPECT_FALSE(filter.update_range(good, 1.0, 5.0, -1, false).accepted);
  EXPECT_EQ(filter.state().minus(Filter::State{}).norm(), 0.0);
  EXPECT_TRUE(filter.covariance().isIdentity(0.0));
  EXPECT_TRUE(filter.update_range(good, 0.0, 5.0).accepted);
  EXPECT_TRUE(filter.update_range(good, 1e100, 5.0).accepted);
  EXPECT_TRUE(filter.covariance().allFinite() && filter.state().position_m.allFinite());
}

}  // namespace
}  // namespace wayfare
