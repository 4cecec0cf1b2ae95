// Gaps, late and faulty measurements, receiver clock jumps: handled and reported.

#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <wayfare/testing/filter_laws.hpp>

#include <wayfare/nav/ins_filter.hpp>

#include "gnss_ins_support.hpp"

namespace wayfare {
namespace {

using namespace tests;
using testing::is_covariance;

/// A minute of driving with good ranges at 2 Hz, to be modified.
struct Scene {
  Drive drive;
  Simulated truth = simulate(drive, 60.0);
  GnssInsRecording recording{truth.imu,
                             simulate_ranges(drive, truth, 0.5, {}, 7),
                             {},
                             GnssInsStart{truth.truth.front(), 1.0, 0.1, 0.01, 0.05}};
  GnssInsOptions options;

  Result<GnssInsResult> run() const { return run_gnss_ins(recording, options); }
};

double end_error_m(const Scene& s, const GnssInsResult& r) {
  return distance_m(r.points.back().nav, s.truth.truth.back());
}

void expect_sound(const GnssInsResult& r) {
  for (const GnssInsPoint& p : r.points) {
    ASSERT_TRUE(p.sigma.allFinite());
    ASSERT_GT(p.sigma.minCoeff(), 0.0F);
    ASSERT_TRUE(p.nav.velocity_ned_mps.allFinite());
    ASSERT_TRUE(std::isfinite(p.nav.position.height_m));
  }
}

class ImuGap : public ::testing::TestWithParam<double> {};

// After the gap the covariance covers the possible motion and the error; at the end the solution
// has recovered.
TEST_P(ImuGap, IsBridgedConsistently) {
  Scene s;
  const double from = 30.0, to = from + GetParam();
  std::erase_if(s.recording.imu, [&](const ImuSample& i) {
    return i.time.seconds() > from + 1e-6 && i.time.seconds() < to - 1e-6;
  });
  std::erase_if(s.recording.ranges, [&](const RangeEpoch& e) {
    return e.time.seconds() > from && e.time.seconds() < to;
  });
  const auto r = s.run();
  ASSERT_TRUE(r) << r.error().to_string();
  expect_sound(*r);
  const auto after = std::find_if(r->points.begin(), r->points.end(),
                                  [&](const auto& p) { return p.nav.time.seconds() >= to - 1e-6; });
  ASSERT_NE(after, r->points.end());
  const NavState& truth =
      s.truth.truth[static_cast<std::size_t>(std::lround(after->nav.time.seconds() / 0.01))];
  const Eigen::Vector3d v = after->nav.velocity_ned_mps - truth.velocity_ned_mps;
  for (int i = 0; i < 3; ++i) EXPECT_LT(std::abs(v[i]), 4.0 * after->sigma[3 + i] + 0.3);
  EXPECT_LT(end_error_m(s, *r), 3.0);
  const bool said = std::any_of(r->notices.begin(), r->notices.end(), [&](const auto& n) {
    return n.text.find("bridged") != std::string::npos && std::abs(n.time.seconds() - from) < 0.02;
  });
  EXPECT_TRUE(said);
}
INSTANTIATE_TEST_SUITE_P(GnssIns, ImuGap, ::testing::Values(0.1, 0.5, 1.0, 3.0, 9.5));

TEST(GnssInsBadInput, ReinitialisesAfterALongGap) {
  Scene s;
  std::erase_if(s.recording.imu, [](const ImuSample& i) {
    return i.time.seconds() > 20.0 && i.time.seconds() < 35.0;
  });
  const auto r = s.run();
  ASSERT_TRUE(r) << r.error().to_string();
  EXPECT_LT(end_error_m(s, *r), 4.0);
  const bool said = std::any_of(r->notices.begin(), r->notices.end(), [](const auto& n) {
    return n.text.find("reinitialising") != std::string::npos;
  });
  EXPECT_TRUE(said);
}

TEST(GnssInsBadInput, DuplicatedAndSwappedReadingsAreRejected) {
  Scene clean, s;
  s.recording.imu.insert(s.recording.imu.begin() + 3000, s.recording.imu[2999]);
  std::swap(s.recording.imu[4000], s.recording.imu[4001]);
  const auto expected = clean.run(), r = s.run();
  ASSERT_TRUE(r && expected);
  EXPECT_NEAR(end_error_m(s, *r), end_error_m(clean, *expected), 0.05);
  EXPECT_EQ(std::count_if(r->notices.begin(), r->notices.end(),
                          [](const auto& n) { return n.text.find("reading") != n.text.npos; }),
            2);
}

TEST(GnssInsBadInput, NanIsRejectedWithAReason) {
  GnssIns filter{GnssInsOptions{}};
  ImuSample bad;
  bad.specific_force_mps2.x() = NAN;
  EXPECT_FALSE(filter.add(bad));
  EXPECT_THAT(filter.add(bad).error().message, ::testing::HasSubstr("implausible"));
  RangeEpoch empty;
  EXPECT_FALSE(filter.add(empty));
  GnssFix fix;
  fix.position.height_m = NAN;
  EXPECT_FALSE(filter.add(fix));
  EXPECT_FALSE(filter.started());
}

// One satellite NaN, one off by a thousand kilometres, one inside the Earth: the rest is used.
TEST(GnssInsBadInput, FaultySatellitesAreIgnored) {
  Scene clean, s;
  for (std::size_t i = 40; i < 80; ++i) {
    auto& e = s.recording.ranges[i].satellites;
    e[0].range_m = NAN;
    e[1].range_m += 1e6;
    e[2].position_ecef_m.setZero();
    e[3].range_rate_mps = -1e5;
  }
  const auto r = s.run();
  ASSERT_TRUE(r) << r.error().to_string();
  expect_sound(*r);
  EXPECT_LT(end_error_m(s, *r), 3.0);
  for (const auto& i : r->innovations) {
    if (i.time.seconds() > 20.6 && i.time.seconds() < 39.0 && i.satellite.number == 2 &&
        i.kind == InnovationRecord::Kind::range) {
      EXPECT_FALSE(i.accepted);
    }
  }
}

class ClockJump : public ::testing::TestWithParam<double> {};

TEST_P(ClockJump, DoesNotMoveThePosition) {
  Scene s;
  for (RangeEpoch& e : s.recording.ranges) {
    if (e.time.seconds() > 25.0) {
      for (auto& r : e.satellites) r.range_m += GetParam();
    }
  }
  const auto r = s.run();
  ASSERT_TRUE(r);
  for (const GnssInsPoint& p : r->points) {
    const auto i = static_cast<std::size_t>(std::lround(p.nav.time.seconds() / 0.01));
    ASSERT_LT(distance_m(p.nav, s.truth.truth[i]), 6.0) << p.nav.time.seconds();
  }
  EXPECT_NEAR(r->points.back().clock_bias_m, 1000.0 + 5.0 * 60.0 + GetParam(), 3.0);
}
INSTANTIATE_TEST_SUITE_P(GnssIns, ClockJump,
                         ::testing::Values(299792.458, -299792.458, 29.9792458e6, 500.0));

// Ranges that arrive two seconds late give the same result as in time.
TEST(GnssIns, LateRangesAreReplayed) {
  const Scene s;
  GnssIns in_time(s.options), late(s.options);
  in_time.start(*s.recording.start);
  late.start(*s.recording.start);
  std::size_t a = 0, b = 0;
  for (const ImuSample& i : s.recording.imu) {
    for (; a < s.recording.ranges.size() && s.recording.ranges[a].time <= i.time; ++a) {
      static_cast<void>(in_time.add(s.recording.ranges[a]));
    }
    const LogTime arrived = i.time - from_seconds(1.999);
    for (; b < s.recording.ranges.size() && s.recording.ranges[b].time <= arrived; ++b) {
      const auto used = late.add(s.recording.ranges[b]);
      ASSERT_TRUE(used) << used.error().to_string();
    }
    ASSERT_TRUE(in_time.add(i));
    ASSERT_TRUE(late.add(i));
  }
  for (; b < s.recording.ranges.size(); ++b) {
    const auto used = late.add(s.recording.ranges[b]);
    EXPECT_TRUE(used) << used.error().to_string();
  }
  const auto x = in_time.estimate(), y = late.estimate();
  EXPECT_LT(distance_m(x.nav, y.nav), 1e-6);
  EXPECT_TRUE(x.covariance.isApprox(y.covariance, 1e-6));
  // Too late or duplicated is rejected.
  RangeEpoch old = s.recording.ranges[10];
  EXPECT_FALSE(late.add(old));
  EXPECT_FALSE(late.add(s.recording.ranges.back()));
  EXPECT_LT(distance_m(late.estimate().nav, y.nav), 1e-12);
}

// An overconfident start 300 m off must be recovered from.
TEST(GnssIns, GateReopens) {
  Scene s;
  s.recording.start->nav.position = geodetic_from_ned({300.0, -200.0, 50.0}, s.drive.origin);
  const auto r = s.run();
  ASSERT_TRUE(r) << r.error().to_string();
  expect_sound(*r);
  EXPECT_LT(end_error_m(s, *r), 4.0);
}

TEST(GnssIns, TwoSystemsHaveTwoClocks) {
  Scene s;
  for (RangeEpoch& e : s.recording.ranges) {
    for (std::size_t k = 5; k < e.satellites.size(); ++k) {
      e.satellites[k].satellite.system = GnssSystem::galileo;
      e.satellites[k].range_m += 37.0;
    }
  }
  const auto r = s.run();
  ASSERT_TRUE(r);
  EXPECT_LT(end_error_m(s, *r), 3.0);
  EXPECT_NEAR(r->points.back().clock_bias_m, 1300.0, 3.0);
}

TEST(GnssIns, AcceptsFixesInsteadOfRanges) {
  Scene s;
  Rng rng(5);
  for (std::size_t i = 100; i < s.truth.truth.size(); i += 100) {
    const NavState& t = s.truth.truth[i];
    GnssFix f;
    f.time = t.time;
    const Eigen::Vector3d off(rng.normal(), rng.normal(), rng.normal());
    f.position = geodetic_from_ned(off, t.position);
    f.velocity_ned_mps = t.velocity_ned_mps;
    f.velocity_covariance_ned *= 0.01;
    s.recording.fixes.push_back(f);
  }
  s.recording.ranges.clear();
  s.recording.start.reset();
  const auto r = s.run();
  ASSERT_TRUE(r) << r.error().to_string();
  EXPECT_LT(end_error_m(s, *r), 1.5);
}

// Smooth straight driving at constant speed resembles standstill. 20 s without satellites must not
// stop it.
TEST(GnssIns, SmoothDrivingIsNoStandstill) {
  Scene s;
  s.drive.swing_rad = 0.0;
  s.truth = simulate(s.drive, 60.0);
  s.recording.imu = s.truth.imu;
  s.recording.ranges = simulate_ranges(s.drive, s.truth, 0.5, {}, 7);
  std::erase_if(s.recording.ranges, [](const RangeEpoch& e) { return e.time.seconds() > 40.0; });
  const auto r = s.run();
  ASSERT_TRUE(r);
  for (const auto& i : r->innovations) {
    if (i.kind == InnovationRecord::Kind::standstill) {
      EXPECT_LT(i.time.seconds(), 7.5);
    }
  }
  EXPECT_NEAR(r->points.back().nav.velocity_ned_mps.norm(), 12.0, 0.5);
}

TEST(GnssIns, ConstraintsHelpWithoutSatellites) {
  Scene s;
  // A gyro bias of 0.3 °/s unknown at the start.
  for (ImuSample& i : s.recording.imu) i.angular_rate_radps += Eigen::Vector3d(3e-3, -2e-3, 1e-3);
  s.options.imu.gyro_bias_radps.sigma.setConstant(5e-3);
  std::erase_if(s.recording.ranges, [](const RangeEpoch& e) { return e.time.seconds() > 30.0; });
  Scene free = s;
  free.options.non_holonomic_in_outage = false;
  const auto with = s.run(), without = free.run();
  ASSERT_TRUE(with && without);
  EXPECT_LT(end_error_m(s, *with), 0.7 * end_error_m(free, *without));
}

TEST(GnssIns, IsDeterministic) {
  const Scene s;
  const auto a = s.run(), b = s.run();
  ASSERT_TRUE(a && b);
  ASSERT_EQ(a->points.size(), b->points.size());
  for (std::size_t i = 0; i < a->points.size(); i += 97) {
    EXPECT_EQ(a->points[i].sigma, b->points[i].sigma);
    EXPECT_EQ(a->points[i].nav.velocity_ned_mps, b->points[i].nav.velocity_ned_mps);
  }
}

TEST(GnssInsBadInput, EmptyRecordingIsAnError) {
  EXPECT_FALSE(run_gnss_ins({}, {}));
  Scene s;
  s.recording.ranges.clear();
  s.recording.start.reset();
  EXPECT_FALSE(s.run());
  std::stop_source source;
  source.request_stop();
  const auto stopped = run_gnss_ins(Scene().recording, {}, {}, source.get_token());
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, ErrorCode::cancelled);
}

// A day at 10 Hz and one epoch per second, at rest on the rotating Earth.
TEST(InsFilter, CovarianceStaysValidForADay) {
  const Geodetic here{Angle::degrees(48.7), Angle::degrees(9.1), 300.0};
  const LocalTangentPlane plane(here);
  const EarthAt<double> at = plane.earth<double>(Eigen::Vector3d::Zero());
  const Eigen::Vector3d rate = level_rates<double>(at, Eigen::Vector3d::Zero()).earth;
  const ImuInterval still{rate, rate, {0, 0, -at.gravity_mps2}, {0, 0, -at.gravity_mps2}, 0.1};
  using Filter = InsFilter<double, 0>;
  Eigen::Matrix<double, 23, 1> sigma;
  sigma << 10, 10, 10, 1, 1, 1, 0.05, 0.05, 3.0, 1e-3, 1e-3, 1e-3, 0.05, 0.05, 0.05, 3e-3, 3e-3,
      3e-3, 3e-3, 3e-3, 3e-3, 1e6, 1e3;
  Filter filter(here, 0.0, {}, Filter::Square(sigma.cwiseAbs2().asDiagonal()),
                InsNoise<double>(ImuNoise{}, {}), Eigen::Vector3d::Zero());
  const auto satellites = sky(here, 8);
  Rng rng(11);
  NavState truth;
  truth.position = here;
  for (int second = 0; second < 86400; ++second) {
    for (int k = 0; k < 10; ++k) filter.predict(still);
    for (int k = 0; k < 8; ++k) {
      CorrectedRange r = range_to(satellites[static_cast<std::size_t>(k)], k + 1, truth,
                                  Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero());
      r.range_m += rng.normal(0.0, 2.0);
      r.range_rate_mps += rng.normal(0.0, 0.1);
      filter.update_range(r, 2.0, 5.0);
      filter.update_range_rate(r, 0.1, 5.0);
    }
    if (second < 60 || second % 600 == 0) {
      ASSERT_TRUE(is_covariance(filter.covariance())) << second << " s";
    }
  }
  EXPECT_LT(ned_from_geodetic(filter.position(), here).norm(), 2.0);
}

}  // namespace
}  // namespace wayfare
