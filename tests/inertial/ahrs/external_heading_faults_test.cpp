// Wrong external headings: rejected and reported, without effect on the estimate.

#include <cmath>
#include <functional>
#include <limits>
#include <optional>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/inertial/ahrs.hpp>
#include <wayfare/inertial/detail/external_heading.hpp>
#include <wayfare/pedestrian/walk_feedback.hpp>
#include "core/at.hpp"
#include "motion.hpp"

namespace wayfare {
namespace {

using testing::kDegree;
using testing::Motion;
using tests::at;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kVariance = kDegree * kDegree;

Motion slow_motion(double duration_s = 60.0) {
  testing::MotionOptions o;
  o.duration_s = duration_s;
  o.turn_radps = 0.2;
  o.rest_s = 2.0;
  o.rate_density = 0.02 * kDegree;
  o.start = SO3d();
  return testing::simulate(o);
}

AhrsParameters external_heading_only() {
  AhrsParameters p;
  p.use_magnetometer = false;
  p.heading_history_s = 1.0;
  return p;
}

/// Clockwise from north.
double compass_of(const SO3d& q) { return compass_of_x<frame::Enu>(q).radians(); }

/// A filter after two seconds, its heading initialised.
struct Started {
  Motion motion = slow_motion(2.0);
  Ahrs<frame::Enu> ahrs{external_heading_only()};
  LogTime now = motion.samples.back().time;

  Started() {
    for (const MargSample& s : motion.samples) ahrs.add(s);
    EXPECT_EQ(ahrs.add_heading({now - from_seconds(0.1), Angle::degrees(90), kVariance}),
              UpdateStatus::used);
    EXPECT_TRUE(ahrs.heading_known());
  }
};

TEST(ExternalHeadingFaults, InvalidFixesAreRejectedWithoutEffect) {
  Started s;
  const auto q = s.ahrs.q_world_body().quaternion().coeffs();
  const Eigen::Matrix3d p = s.ahrs.world_covariance();
  const auto add = [&](double after_s, double degrees, double variance) {
    return s.ahrs.add_heading({s.now + from_seconds(after_s), Angle::degrees(degrees), variance});
  };
  EXPECT_EQ(add(0, kNan, kVariance), UpdateStatus::missing);
  EXPECT_EQ(add(0, kInf, kVariance), UpdateStatus::missing);
  for (const double variance : {kNan, kInf, 0.0, -1.0})
    EXPECT_EQ(add(0, 90, variance), UpdateStatus::missing);
  EXPECT_EQ(add(0.2, 90, kVariance), UpdateStatus::waiting);  // in the future
  EXPECT_EQ(add(1e6, 90, kVariance), UpdateStatus::waiting);
  EXPECT_EQ(add(-1.2, 90, kVariance), UpdateStatus::late);  // older than the history
  EXPECT_EQ(add(-1e6, 90, kVariance), UpdateStatus::late);
  EXPECT_EQ(add(-0.1, 90, kVariance), UpdateStatus::late);  // not after the previous fix
  EXPECT_EQ(add(0, 150, kVariance), UpdateStatus::disturbed);
  EXPECT_EQ(s.ahrs.q_world_body().quaternion().coeffs(), q);
  EXPECT_EQ(s.ahrs.world_covariance(), p);
  const SensorReport& r = s.ahrs.report().external;
  EXPECT_EQ(r.used, 1U);
  EXPECT_EQ(r.missing, 6U);
  EXPECT_EQ(r.waiting, 2U);
  EXPECT_EQ(r.late, 3U);
  EXPECT_EQ(r.disturbed, 1U);
}

TEST(ExternalHeadingFaults, WaitsWithoutAttitudeHistoryOrHeading) {
  Ahrs<frame::Enu> fresh(external_heading_only());
  EXPECT_EQ(fresh.add_heading({LogTime(), Angle(), kVariance}), UpdateStatus::waiting);
  AhrsParameters none = external_heading_only();
  none.heading_history_s = 0.0;
  Ahrs<frame::Enu> without_history(none);
  const Motion motion = slow_motion(2.0);
  for (const MargSample& s : motion.samples) without_history.add(s);
  EXPECT_EQ(without_history.add_heading({motion.samples.back().time, Angle(), kVariance}),
            UpdateStatus::waiting);
  AhrsParameters upright = external_heading_only();
  upright.heading_axis = Eigen::Vector3d::UnitZ();
  Ahrs<frame::Enu> no_heading(upright);
  for (const MargSample& s : motion.samples) no_heading.add(s);
  EXPECT_EQ(no_heading.add_heading({motion.samples.back().time, Angle(), kVariance}),
            UpdateStatus::waiting);
}

struct After {
  double off_deg;  ///< of the heading at the end
  AhrsReport report;
};

/// One heading per second, each modified by `corrupt(second, rad)`.
After run_with(const std::function<double(int, double)>& corrupt) {
  const Motion motion = slow_motion();
  Ahrs<frame::Enu> ahrs(external_heading_only());
  for (std::size_t i = 0; i < motion.samples.size(); ++i) {
    ahrs.add(motion.samples[i]);
    if (i % 100 != 50) continue;
    const double heading = corrupt(static_cast<int>(i / 100), compass_of(motion.q_enu_body[i]));
    ahrs.add_heading({motion.samples[i].time, Angle::radians(heading), kVariance});
  }
  const double off = compass_of(ahrs.q_world_body()) - compass_of(motion.q_enu_body.back());
  return {Angle::radians(wrap_to_pi(off)).degrees(), ahrs.report()};
}

TEST(ExternalHeadingFaults, OutliersAreRejected) {
  Rng rng(1);
  const After a = run_with(
      [&](int second, double heading) { return second % 5 == 3 ? rng.uniform() * 6.28 : heading; });
  EXPECT_LT(std::abs(a.off_deg), 1.0);
  EXPECT_GE(a.report.external.disturbed, 10U);
  EXPECT_EQ(a.report.heading_resets, 0U);
}

TEST(ExternalHeadingFaults, ConsistentlyRejectedHeadingsResetTheHeading) {
  const After a =
      run_with([](int second, double heading) { return second < 30 ? heading : heading + 0.5; });
  EXPECT_NEAR(a.off_deg, 28.65, 1.0);
  EXPECT_EQ(a.report.heading_resets, 1U);
  EXPECT_NEAR(static_cast<double>(a.report.external.disturbed), 10.0, 1.0);
  Rng rng(2);
  const After b = run_with(
      [&](int second, double heading) { return second < 30 ? heading : rng.uniform() * 6.28; });
  // Some fall within the gate, which after 30 s is 4·√(30·0.3² + 1²) = 7.7° wide.
  EXPECT_LT(std::abs(b.off_deg), 10.0);
  EXPECT_EQ(b.report.heading_resets, 0U);
}

// After a gyro gap the next external heading initialises the heading.
TEST(ExternalHeadingFaults, InitialisesTheHeadingAfterAGap) {
  Started s;
  const LogTime later = s.now + from_seconds(5.0);
  for (int i = 0; i < 20; ++i) {
    MargSample sample = s.motion.samples.back();
    sample.time = later + from_seconds(0.01 * i);
    s.ahrs.add(sample);
  }
  EXPECT_FALSE(s.ahrs.heading_known());
  EXPECT_EQ(s.ahrs.add_heading({s.now, Angle::degrees(10), kVariance}), UpdateStatus::late);
  EXPECT_EQ(s.ahrs.add_heading({later + from_seconds(0.15), Angle::degrees(10), kVariance}),
            UpdateStatus::used);
  EXPECT_NEAR(compass_of(s.ahrs.q_world_body()), 10 * kDegree, 0.02 * kDegree);
}

TEST(ExternalHeadingFaults, StaysFiniteOnRandomFixes) {
  Rng rng(5);
  Ahrs<frame::Ned, float> ahrs(external_heading_only());
  const Motion motion = slow_motion(300.0);
  for (const MargSample& s : motion.samples) {
    ahrs.add(s);
    const double ahead = rng.normal() * 0.5, variance = std::pow(10.0, 10 * rng.normal());
    ahrs.add_heading({s.time + from_seconds(ahead), Angle::radians(rng.normal() * 10),
                      rng.below(5) == 0 ? -variance : variance});
    ASSERT_TRUE(ahrs.q_world_body().quaternion().coeffs().allFinite());
    ASSERT_TRUE(ahrs.world_covariance().allFinite());
    ASSERT_TRUE(ahrs.gyro_bias_radps().allFinite());
    ASSERT_GE(ahrs.world_covariance().diagonal().minCoeff(), 0.0F);
  }
  EXPECT_GT(ahrs.report().external.used, 100U);
}

// The mean of n samples of a Gauss-Markov error has, for large n, (1 + ρ)/(1 − ρ) times the
// variance of the mean of white ones; a match correlated with its prior gets a larger variance.
TEST(MapHeading, DecorrelatesMatchesAtTheSpacing) {
  const MapHeadingParameters p{
      .spacing_s = 1.0, .sigma = Angle::radians(0.01), .correlation_s = 5.0};
  MapHeading map(p);
  const double prior = 1e-2;
  ASSERT_TRUE(map.independent_variance(LogTime::from_seconds(1.0), 1e-9, prior));
  EXPECT_FALSE(map.independent_variance(LogTime::from_seconds(1.9), 1e-9, prior));
  const auto variance = map.independent_variance(LogTime::from_seconds(2.0), 1e-9, prior);
  ASSERT_TRUE(variance);
  constexpr int n = 2000;
  double sum = 0.0;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) sum += 1e-4 * std::exp(-std::abs(i - j) / p.correlation_s);
  EXPECT_NEAR(*variance / n, sum / n / n, 0.01 * *variance / n);
  const auto half = map.independent_variance(LogTime::from_seconds(3.0), prior / 3,
                                             prior);  // a quarter the prior's
  EXPECT_NEAR(*half, (*variance + prior / 3) / (0.75 * 0.75), 1e-6);
  EXPECT_FALSE(map.independent_variance(LogTime::from_seconds(5.0), 5.0 * prior, prior));
  for (const double bad : {kNan, kInf, 0.0, -1.0}) {
    EXPECT_FALSE(map.independent_variance(LogTime::from_seconds(7.0), bad, prior));
    EXPECT_FALSE(map.independent_variance(LogTime::from_seconds(7.0), 1e-4, bad));
  }
}

TEST(HeadingTrack, InterpolatesAndExtrapolatesBriefly) {
  HeadingTrack track(1.0);
  for (int i = 0; i <= 200; ++i) track.add(at(0.01 * i), {0.02, {0.0, 0.0, 0.01}, 1e-6});
  const auto then = track.at(at(1.505));
  ASSERT_TRUE(then);
  const HeadingTrack::Sum since = track.now() - *then;
  EXPECT_NEAR(since.angle, 49.5 * 0.02, 1e-12);
  EXPECT_NEAR(since.rotation({0, 0, 0.5}), 49.5 * (0.02 - 0.005), 1e-12);
  EXPECT_NEAR(since.variance, 49.5e-6, 1e-15);
  EXPECT_NEAR((*track.at(at(2.03)) - track.now()).angle, 3 * 0.02, 1e-12);
  EXPECT_FALSE(track.at(at(0.99)));
  EXPECT_FALSE(track.in_future(at(0.99)));
  EXPECT_FALSE(track.at(at(2.2)));
  EXPECT_TRUE(track.in_future(at(2.2)));
}

// At 5 kHz entries are spaced further apart than the readings, for the same duration.
TEST(HeadingTrack, KeepsItsDurationAtAnyRate) {
  HeadingTrack track(1.0);
  for (int i = 0; i <= 10000; ++i) track.add(at(0.0002 * i), {0.001, {0, 0, 0}, 0.0});
  for (double s = 1.001; s < 2.0; s += 0.0137) {
    ASSERT_TRUE(track.at(at(s))) << s;
    EXPECT_NEAR((track.now() - *track.at(at(s))).angle, (2.0 - s) / 0.0002 * 0.001, 0.0011);
  }
}

}  // namespace
}  // namespace wayfare
