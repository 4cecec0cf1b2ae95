// Corridor-aided dead reckoning and outages with samples, scans and plans that are none.

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/nav/corridor_ins.hpp>
#include <wayfare/nav/outage.hpp>

#include "abuse/abuse.hpp"

namespace wayfare {
namespace {

using namespace tests;

const LogTime kBegin = LogTime() + Duration::min(), kEnd = LogTime() + Duration::max();
constexpr float kNanF = std::numeric_limits<float>::quiet_NaN();

/// Along x between walls 1 m to the left and right.
LaserScan corridor_scan(LogTime time) {
  LaserScan scan{time, Angle::degrees(-180), Angle::degrees(1), 0.05F, 12.0F, {}};
  for (std::size_t i = 0; i < 360; ++i) {
    const double s = std::abs(std::sin(scan.bearing(i).radians()));
    scan.ranges_m.push_back(s > 0.1 ? static_cast<float>(1.0 / s) : kNanF);
  }
  return scan;
}

void drive(CorridorIns& ins, double from_s, double to_s) {
  for (long i = std::lround(10.0 * from_s); i < std::lround(10.0 * to_s); ++i) {
    const LogTime time = LogTime() + i * std::chrono::milliseconds(100);
    EXPECT_TRUE(ins.add_motion({time, 0.001, 0.5}));
    EXPECT_TRUE(ins.add_scan(corridor_scan(time)));
  }
}

CorridorIns running() {
  CorridorIns ins;
  drive(ins, 0.0, 2.0);
  return ins;
}

void expect_sound(const CorridorIns& ins) {
  ASSERT_TRUE(ins.state().minus({}).allFinite());
  ASSERT_TRUE(ins.covariance().allFinite());
  const auto variances = ins.covariance().diagonal();
  ASSERT_GE(variances.minCoeff(), -1e-12 * variances.maxCoeff());  // but for rounding
  ASSERT_TRUE(std::isfinite(ins.gyro_bias().sigma) && std::isfinite(ins.speed_scale().sigma));
}

TEST(CorridorAbuse, ImplausibleSamplesAreRefusedWithoutEffect) {
  CorridorIns ins = running();
  EXPECT_GT(ins.report().scans_used, 10U);
  const CorridorState before = ins.state();
  const LogTime next = LogTime::from_seconds(2.0);
  for (const double x : {kNan, kInf, -kInf, kHuge, -kHuge, 1e9}) {
    EXPECT_FALSE(ins.add_motion({next, x, 0.5})) << x;
    EXPECT_FALSE(ins.add_motion({next, 0.0, x})) << x;
  }
  for (const LogTime time : {kBegin, LogTime::from_seconds(-1e9), LogTime::from_seconds(1.0)}) {
    EXPECT_FALSE(ins.add_motion({time, 0.0, 0.5}));
    EXPECT_FALSE(ins.add_scan(corridor_scan(time)));
  }
  EXPECT_EQ(ins.state().minus(before), CorridorState::Tangent::Zero());
  EXPECT_EQ(ins.report().refused_samples, 15U);
  drive(ins, 2.0, 3.0);
  expect_sound(ins);
}

TEST(CorridorAbuse, GapsOfAnyLengthAndTheFastestMotionStayFinite) {
  for (const LogTime time : {LogTime::from_seconds(1e9), kEnd}) {
    for (const double speed : {0.0, 0.5, 999.0, -999.0}) {
      CorridorIns ins = running();
      EXPECT_TRUE(ins.add_motion({time, 999.0, speed}));
      expect_sound(ins);
      EXPECT_TRUE(ins.add_scan(corridor_scan(time)));
      expect_sound(ins);
      EXPECT_TRUE(ins.report().longest_outage >= Duration(0));
    }
  }
}

// Eleven days at a speed known to 0.5 %: the position is unknown by kilometres.
TEST(CorridorAbuse, IsReinitialisedWhenThePoseIsUnknown) {
  CorridorIns ins = running();
  const std::size_t corridors = ins.report().corridors;
  const double scale = ins.speed_scale().sigma;
  const LogTime late = LogTime::from_seconds(1e6);
  EXPECT_TRUE(ins.add_motion({late, 0.001, 0.5}));
  ASSERT_FALSE(ins.report().events.empty());
  EXPECT_EQ(ins.report().events.back().what, "heading or position unknown");
  EXPECT_EQ(ins.pose_covariance(), Eigen::Matrix3d(Eigen::Vector3d(1e4, 1e4, 10.0).asDiagonal()));
  const CorridorInsOptions start;
  EXPECT_DOUBLE_EQ(ins.gyro_bias().sigma,
                   std::hypot(start.start_bias_rad_s, start.noise.bias_sigma_rad_s));
  EXPECT_EQ(ins.gyro_drift().sigma, start.start_drift_rad_s2);
  EXPECT_EQ(ins.speed_scale().sigma, scale);
  const auto update = ins.add_scan(corridor_scan(late));
  ASSERT_TRUE(update);
  EXPECT_EQ(update->outcome, WallOutcome::reacquired);
  EXPECT_EQ(ins.report().corridors, corridors + 1);
  EXPECT_EQ(ins.pose_covariance()(2, 2), 10.0) << "walls of unknown direction give no heading";
}

TEST(CorridorAbuse, StrangeScansDoNoHarm) {
  std::vector<LaserScan> strange;
  const LaserScan good = corridor_scan({});
  for (const double x : {kNan, kInf, -kInf, kHuge, 0.0, kTiny, -1.0}) {
    strange.insert(strange.end(), 4, good);
    const auto s = strange.end() - 4;
    s[0].first_bearing = Angle::radians(x);
    s[1].bearing_step = Angle::radians(x);
    s[2].max_range_m = static_cast<float>(x);
    s[3].ranges_m.assign(360, static_cast<float>(x));
  }
  strange.push_back(good);
  strange.back().ranges_m.assign(200'000, 1.0F);
  strange.push_back(good);
  strange.back().ranges_m = {1.0F};
  for (std::size_t i = 0; i < strange.size(); ++i) {
    SCOPED_TRACE(i);
    CorridorIns ins = running();
    strange[i].time = LogTime::from_seconds(2.0);
    EXPECT_TRUE(ins.add_motion({strange[i].time, 0.0, 0.5}));
    static_cast<void>(ins.add_scan(strange[i]).has_value());
    expect_sound(ins);
    drive(ins, 2.1, 3.0);
    expect_sound(ins);
  }
}

TEST(CorridorAbuse, MovesAndRunsInTwoThreads) {
  const auto probe = [](CorridorIns& ins) {
    drive(ins, 2.0, 3.0);
    return std::tuple(ins.pose().x(), ins.covariance().sum(), ins.report().scans_used);
  };
  expect_move_semantics(running, probe);
  const auto results = in_two_threads([&](int) {
    CorridorIns ins = running();
    return probe(ins);
  });
  EXPECT_EQ(results[0], results[1]);
}

Recording recording() {
  Recording r;
  for (int i = 0; i < 100; ++i) {
    const LogTime time = LogTime::from_seconds(0.1 * i);
    r.gyro.push_back({time, 0.01});
    r.wheels.push_back({time, 0.05, 0.05});
    r.odometry.push_back(
        {time, Transform2<frame::Odom, frame::Base>(SE2d(0.05 * i, 0.0, Angle()))});
    r.scans.push_back(corridor_scan(time));
  }
  return r;
}

TEST(CorridorAbuse, OneBadWheelSampleDoesNotSpoilTheRest) {
  for (const double x : kNotFinite) {
    Recording r = recording();
    r.wheels[50].left_m = x;
    for (const MotionSample& m : motion_of(r)) EXPECT_TRUE(std::isfinite(m.speed_m_s));
    r.wheels.clear();
    r.odometry[50].T_odom_base = Transform2<frame::Odom, frame::Base>(SE2d(x, 0.0, Angle()));
    // 0.05 m in 0.1 s, interpolated across the sample that is left out; none before the first.
    const auto with_gyro = motion_of(r);
    EXPECT_EQ(with_gyro.size(), 100U);
    for (std::size_t i = 1; i < with_gyro.size(); ++i)
      EXPECT_NEAR(with_gyro[i].speed_m_s, 0.5, 1e-9);
    r.gyro.clear();
    const auto motion = motion_of(r);
    EXPECT_EQ(motion.size(), 99U);
    for (std::size_t i = 1; i < motion.size(); ++i) EXPECT_NEAR(motion[i].speed_m_s, 0.5, 1e-9);
    const auto run = run_corridor_ins(r, motion);
    ASSERT_TRUE(run);
    EXPECT_EQ(run->epochs.size(), 100U);
  }
}

TEST(CorridorAbuse, RecordingsOfNothingRepeatedAndReversed) {
  EXPECT_TRUE(motion_of({}).empty());
  Recording r = recording();
  EXPECT_FALSE(run_corridor_ins(r, {}));
  const auto motion = motion_of(r);
  Recording none = r;
  none.scans.clear();
  EXPECT_FALSE(run_corridor_ins(none, motion));
  Recording same = r;
  same.scans.assign(50, r.scans[7]);
  const auto once = run_corridor_ins(same, motion);
  ASSERT_TRUE(once);
  EXPECT_EQ(once->epochs.size(), 1U);
  EXPECT_EQ(once->refused_scans, 49U);
  EXPECT_FALSE(once->first_refusal.empty());
  Recording reversed = r;
  std::reverse(reversed.gyro.begin(), reversed.gyro.end());
  std::reverse(reversed.scans.begin(), reversed.scans.end());
  EXPECT_EQ(motion_of(reversed).size(), 1U);
  ASSERT_TRUE(run_corridor_ins(reversed, motion_of(reversed)));
  Recording repeated = r;
  repeated.gyro.assign(100, r.gyro[3]);
  repeated.wheels.assign(100, r.wheels[3]);
  EXPECT_EQ(motion_of(repeated).size(), 1U);
  // A gyro, and wheels without any finite sample: the robot is not known to stand.
  Recording broken;
  broken.gyro = r.gyro;
  broken.wheels.assign(3, {LogTime(), kNan, kNan});
  EXPECT_TRUE(motion_of(broken).empty());
}

TEST(OutageAbuse, WindowsAndStartsOfNothing) {
  EXPECT_TRUE(outage_starts(LogTime(), LogTime(), Duration(0), 0).empty());
  EXPECT_EQ(outage_starts(kBegin, kEnd, Duration(0), 2).size(), 2U);
  EXPECT_EQ(outage_starts(kEnd, kBegin, Duration(0), 3).size(), 3U);  // reversed
  EXPECT_EQ(outage_starts(LogTime(), kEnd, std::chrono::seconds(30), 3, {}).size(), 3U);
  const OutageWindow window{kEnd, kBegin};
  EXPECT_FALSE(window.contains(LogTime()));
  const auto truth = [](LogTime t) { return NavState{t, {}, Eigen::Vector3d::Zero(), {}}; };
  EXPECT_TRUE(drift_during({kBegin, kEnd}, {}, truth).empty());
  std::vector<NavState> estimates(3);
  estimates[1].position.height_m = kNan;
  EXPECT_EQ(drift_during({kBegin, kEnd}, estimates, truth).size(), 3U);
  EXPECT_TRUE(std::isnan(error_of({}, std::chrono::seconds(1)).rmse_m));
  EXPECT_TRUE(mask_satellites({}, window, {}).empty());
  GnssInsRecording nothing;
  apply_outage({kBegin, kEnd}, nothing);
  EXPECT_TRUE(nothing.ranges.empty());
}

TEST(OutageAbuse, SatellitesWithoutAPositionAreMaskedToo) {
  std::vector<RangeEpoch> epochs(4);
  for (RangeEpoch& e : epochs) {
    e.satellites.resize(40);
    for (std::size_t i = 0; i < 40; ++i) {
      e.satellites[i].satellite.number = static_cast<std::uint8_t>(i % 20);
      e.satellites[i].position_ecef_m.setConstant(i % 3 == 0 ? kNan : i % 3 == 1 ? 0.0 : kHuge);
    }
  }
  for (const std::size_t left :
       {std::size_t{0}, std::size_t{5}, std::numeric_limits<std::size_t>::max()}) {
    const auto masked = mask_satellites(epochs, {kBegin, kEnd, left}, {});
    for (const RangeEpoch& e : masked)
      EXPECT_EQ(e.satellites.size(), std::min<std::size_t>(left, 40));
  }
}

TEST(OutageAbuse, RunsThatAnswerNothingOrGoBackAreErrors) {
  OutagePlan plan;
  plan.starts = {kBegin, LogTime(), kEnd};
  plan.threads = 4;
  const TrueState truth = [](LogTime t) { return NavState{t, {}, Eigen::Vector3d::Zero(), {}}; };
  EXPECT_FALSE(run_outages(
      plan, [](const OutageWindow&) { return Result<NavTrajectory>(NavTrajectory{}); }, truth));
  EXPECT_FALSE(run_outages(
      plan, [](const OutageWindow&) { return Result<NavTrajectory>(NavTrajectory(5)); }, truth));
  plan.starts = {LogTime::from_seconds(1)};
  const auto constant = [](const OutageWindow& w) {
    NavTrajectory same(100);
    for (NavState& s : same) s.time = w.begin + std::chrono::seconds(1);
    return Result<NavTrajectory>(same);
  };
  const auto report = run_outages(plan, constant, truth);
  ASSERT_TRUE(report);
  EXPECT_EQ(report->cells.size(), 25U);
  EXPECT_EQ(report->mean(std::chrono::seconds(10), 0).rmse_m, 0.0);
  EXPECT_DEATH(static_cast<void>(report->mean(std::chrono::seconds(11), 0)), "no such outage");
  EXPECT_DEATH(static_cast<void>(run_outages(OutagePlan{}, constant, truth)), "need a duration");
}

}  // namespace
}  // namespace wayfare
