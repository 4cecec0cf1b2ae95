// The foot-mounted tracker on simulated walks and faulty input.
#include <wayfare/pedestrian/detail/foot_filter.hpp>
#include <wayfare/pedestrian/detail/foot_noise.hpp>
#include <wayfare/pedestrian/detail/foot_readings.hpp>
#include <wayfare/pedestrian/foot_tracker.hpp>
#include <wayfare/pedestrian/parameters.hpp>

#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

#include <wayfare/sync/odometry_track.hpp>
#include "foot_recordings.hpp"
#include "foot_walk.hpp"

namespace wayfare {
namespace {

using Eigen::Vector3d;
using testing::FootWalk;
using testing::FootWalkOptions;
using testing::run_foot;
using testing::walk_foot;

/// Distance of the last pose from the true position. The tracker's x axis is the sensor's initial
/// one, so both agree for an aligned sensor.
double end_error(const std::vector<FootPose>& poses, const FootWalk& walk) {
  return (poses.back().position_m - walk.position.back()).norm();
}

TEST(StanceStatistic, IsAboutOneAtRestAndGrowsWithMotion) {
  FootParameters p;
  std::vector<ImuSample> still(11);
  for (auto& s : still) s.specific_force_mps2 = {0.0, 0.0, p.gravity_mps2};
  EXPECT_NEAR(stance_statistic(still.begin(), still.end(), p), 0.0, 1e-12);
  for (auto& s : still) s.angular_rate_radps = {p.stance_rate_sigma, 0.0, 0.0};
  EXPECT_NEAR(stance_statistic(still.begin(), still.end(), p), 1.0, 1e-12);
  for (auto& s : still) s.specific_force_mps2.z() += 2.0 * p.stance_force_sigma;
  EXPECT_NEAR(stance_statistic(still.begin(), still.end(), p), 5.0, 1e-12);
  p.statistic = StanceStatistic::ared;
  EXPECT_NEAR(stance_statistic(still.begin(), still.end(), p), 1.0, 1e-12);
}

// Forty strides with the biases and noise of a good unit: 0.3 % of 52 m.
TEST(FootTracker, FollowsAWalk) {
  for (const auto statistic : {StanceStatistic::shoe, StanceStatistic::ared}) {
    FootParameters p;
    p.statistic = statistic;
    const FootWalk walk = walk_foot({});
    const auto poses = run_foot(walk.samples, p);
    ASSERT_EQ(poses.size(), walk.samples.size());
    EXPECT_LT(end_error(poses, walk), 0.003 * walk.length_m);
    EXPECT_NEAR(poses.back().heading.radians(), wrap_to_pi(40 * 0.15), 0.02);
  }
}

// One setting from a stroll to a run of 3.7 m/s with stances of a tenth of a second.
TEST(FootTracker, OneSettingServesEverySpeed) {
  struct Gait {
    double swing_s, stance_s, stride_m;
  };
  for (const Gait g : {Gait{0.9, 0.9, 0.8}, Gait{0.45, 0.4, 1.3}, Gait{0.5, 0.1, 2.2}}) {
    FootWalkOptions o;
    o.swing_s = g.swing_s;
    o.stance_s = g.stance_s;
    o.stride_m = g.stride_m;
    const FootWalk walk = walk_foot(o);
    EXPECT_LT(end_error(run_foot(walk.samples, {}), walk), 0.006 * walk.length_m) << g.stride_m;
  }
}

TEST(FootTracker, ClimbsStairsAndKeepsFloorsLevel) {
  FootWalkOptions o;
  o.climb_m = 0.17 * 2;
  o.stride_m = 0.6;
  const FootWalk stairs = walk_foot(o);
  const auto climbed = run_foot(stairs.samples, {});
  EXPECT_NEAR(climbed.back().position_m.z(), 40 * 0.34, 0.1);
  o.climb_m = 0.0;
  o.force_bias = {0.1, -0.1, 0.3};
  const FootWalk floor = walk_foot(o);
  FootParameters no_rule;
  no_rule.level_step_m = 0.0;
  const double without = std::abs(run_foot(floor.samples, no_rule).back().position_m.z());
  const double level = std::abs(run_foot(floor.samples, {}).back().position_m.z());
  EXPECT_LT(level, 0.05);
  EXPECT_LT(level, 0.5 * without);
}

// The path does not depend on mounting or sampling rate.
TEST(FootTracker, IsIndependentOfMountingAndRate) {
  FootWalkOptions o;
  const FootWalk straight = walk_foot(o);
  const double distance = run_foot(straight.samples, {}).back().position_m.norm();
  o.q_foot_sensor = SO3d::exp({1.1, -0.7, 2.0});
  o.rate_bias.setZero();
  o.force_bias.setZero();
  const FootWalk turned = walk_foot(o);
  const Vector3d end = run_foot(turned.samples, {}).back().position_m;
  EXPECT_NEAR(end.norm(), straight.position.back().norm(), 0.05);
  EXPECT_NEAR(distance, straight.position.back().norm(), 0.003 * straight.length_m);
  for (const double hz : {100.0, 400.0}) {
    o = {};
    o.rate_hz = hz;
    const FootWalk walk = walk_foot(o);
    EXPECT_LT(end_error(run_foot(walk.samples, {}), walk), 0.006 * walk.length_m) << hz;
  }
}

TEST(FootFilter, PropagatesAsDenseMatricesDo) {
  FootFilter filter;
  filter.set_attitude(SO3d::exp({0.3, -0.2, 1.0}), {1e-4, 2e-4, 3e-4});
  filter.set_velocity({1.0, 2.0, -0.5}, 0.01);
  filter.set_bias_variances(1e-6, 1e-2);
  constexpr double kGravity_mps2 = 9.80665, kDt_s = 0.01;
  for (int i = 0; i < 100; ++i) {
    const Vector3d rate(2.0 * std::sin(0.1 * i), -1.0, 0.5), force(3.0, std::cos(0.2 * i), 9.0);
    const FootFilter before = filter;
    filter.predict(rate, force, kGravity_mps2, kDt_s);
    const Eigen::Matrix3d middle =
        (before.q_world_foot() * SO3d::exp(0.5 * kDt_s * (rate - before.rate_bias()))).matrix();
    FootFilter::Covariance phi = FootFilter::Covariance::Identity();
    phi.block<3, 3>(0, 3) = kDt_s * Eigen::Matrix3d::Identity();
    phi.block<3, 3>(3, 6) = -kDt_s * skew<double>(middle * (force - before.force_bias()));
    phi.block<3, 3>(3, 12) = phi.block<3, 3>(6, 9) = -kDt_s * middle;
    const FootFilter::Covariance expected = phi * before.covariance() * phi.transpose();
    ASSERT_LT((filter.covariance() - expected).norm(), 1e-14 * expected.norm()) << i;
    filter.add_noise({1e-8, 1e-6, 1e-8, 1e-12, 1e-9});
    if (i % 10 == 9) filter.observe<FootFilter::kVelocity>(Vector3d::Zero(), 1e-4);
  }
}

TEST(FootTracker, CovarianceStaysPositiveAndCoversTheError) {
  double squares = 0.0;
  constexpr int kRuns = 40;
  for (int run = 0; run < kRuns; ++run) {
    FootWalkOptions o;
    o.strides = 20;
    o.seed = static_cast<std::uint64_t>(run + 1);
    const FootWalk walk = walk_foot(o);
    FootTracker tracker;
    const auto check = [&](const FootPose& pose) {
      const Eigen::SelfAdjointEigenSolver<FootFilter::Covariance> eigen(
          tracker.filter().covariance(), Eigen::EigenvaluesOnly);
      ASSERT_GT(eigen.eigenvalues().minCoeff(), -1e-12);
      ASSERT_TRUE(pose.position_m.allFinite());
    };
    for (std::size_t i = 0; i < walk.samples.size(); ++i) {
      if (i % 20 == 0)
        tracker.add(walk.samples[i], check);
      else
        tracker.add(walk.samples[i]);
    }
    tracker.finish([](const FootPose&) {});
    const FootPose& end = tracker.pose();
    const Vector3d e = end.position_m - walk.position.back();
    squares +=
        e.head<2>().dot(end.position_covariance_m2.topLeftCorner<2, 2>().inverse() * e.head<2>());
  }
  // Two degrees of freedom per run. The filter's noise exceeds the simulation's: it must not be
  // overconfident, nor more than a hundredfold underconfident.
  EXPECT_LT(squares / kRuns, 3.0);
  EXPECT_GT(squares / kRuns, 0.02);
}

// A clipped rotation is lost, but with a known range the covariance covers it.
TEST(FootTracker, SaturationAddsToTheUncertainty) {
  FootWalkOptions o;
  o.pitch_rad = 1.2;
  o.rate_range = 7.0;
  const FootWalk walk = walk_foot(o);
  FootParameters knows;
  knows.rate_range = 6.9;
  FootTracker tracker(knows);
  for (const auto& s : walk.samples) tracker.add(s);
  EXPECT_GT(tracker.report().gyro.saturated, 100U);
  const auto poses = run_foot(walk.samples, knows);
  const double sigma = std::sqrt(poses.back().position_covariance_m2.trace());
  EXPECT_LT(end_error(poses, walk), 3.0 * sigma);
  EXPECT_LT(end_error(poses, walk), 0.02 * walk.length_m);
}

TEST(FootTracker, IsAnOdometryTrack) {
  const FootWalk walk = walk_foot({});
  std::vector<OdometrySample> odometry;
  for (const FootPose& p : run_foot(walk.samples, {})) odometry.push_back(p.odometry());
  const OdometryTrack track(odometry);
  const auto end = track.at(odometry.back().time);
  ASSERT_TRUE(end);
  EXPECT_NEAR(end->raw().x(), walk.position.back().x(), 0.2);
  EXPECT_NEAR(end->raw().heading().radians(), wrap_to_pi(6.0), 0.02);
}

TEST(FootTracker, DelayIsAsDocumented) {
  const FootWalk walk = walk_foot({});
  FootTracker tracker;
  double latest_s = 0.0;
  for (const auto& s : walk.samples)
    tracker.add(
        s, [&](const FootPose& p) { latest_s = std::max(latest_s, to_seconds(s.time - p.time)); });
  const FootParameters p;
  EXPECT_LT(latest_s, p.stance_apart_s + 0.5 * p.stance_window_s + 0.011);
}

// --- faulty input -----------------------------------------------------------------------------

struct Damaged {
  FootTracker tracker;
  std::vector<FootPose> poses;

  explicit Damaged(const std::vector<ImuSample>& samples) {
    const auto keep = [&](const FootPose& p) { poses.push_back(p); };
    for (const auto& s : samples) tracker.add(s, keep);
    tracker.finish(keep);
    for (const auto& p : poses) {
      EXPECT_TRUE(p.position_m.allFinite() && p.velocity_mps.allFinite());
      EXPECT_TRUE(p.position_covariance_m2.allFinite());
    }
  }
};

/// The walk with its middle second modified by `change(i, sample)`, which returns false to drop a
/// sample.
template <class Change>
std::vector<ImuSample> damage(const FootWalk& walk, Change change) {
  std::vector<ImuSample> samples;
  const std::size_t middle = walk.samples.size() / 2;
  for (std::size_t i = 0; i < walk.samples.size(); ++i) {
    ImuSample s = walk.samples[i];
    if (i < middle || i >= middle + 200 || change(i - middle, s)) samples.push_back(s);
  }
  return samples;
}

TEST(FootBadInput, MissingReadingsAreReportedAndBridged) {
  const FootWalk walk = walk_foot({});
  const auto nan = std::numeric_limits<double>::quiet_NaN();
  const Damaged some(damage(walk, [&](std::size_t i, ImuSample& s) {
    if (i % 10 == 3) s.specific_force_mps2.y() = nan;
    return true;
  }));
  EXPECT_EQ(some.tracker.report().accelerometer.missing, 20U);
  EXPECT_LT(end_error(some.poses, walk), 0.5);
  const Damaged second(damage(walk, [](std::size_t, ImuSample&) { return false; }));
  EXPECT_EQ(second.tracker.report().gaps, 1U);
  // One unobserved stride, and no more.
  EXPECT_LT(end_error(second.poses, walk), 3.0);
  EXPECT_GT(second.poses.back().position_covariance_m2.trace(), 0.5);
}

TEST(FootBadInput, TimeBackwardsIsLate) {
  const FootWalk walk = walk_foot({});
  const Damaged d(damage(walk, [](std::size_t i, ImuSample& s) {
    if (i % 20 == 0) s.time = s.time - std::chrono::milliseconds(12);
    return true;
  }));
  EXPECT_EQ(d.tracker.report().gyro.late, 10U);
  EXPECT_LT(end_error(d.poses, walk), 1.0);
  // After a clock set back permanently, time restarts and the position is kept.
  auto samples = walk.samples;
  for (std::size_t i = samples.size() / 2; i < samples.size(); ++i)
    samples[i].time = samples[i].time - std::chrono::seconds(100);
  const Damaged set_back(samples);
  EXPECT_GT(set_back.tracker.report().gyro.late, 0U);
  EXPECT_GE(set_back.tracker.report().gaps, 1U);
  EXPECT_LT(end_error(set_back.poses, walk), 10.0);
}

TEST(FootBadInput, ReadingsFarOutOfRangeAreMissing) {
  const FootWalk walk = walk_foot({});
  const Damaged d(damage(walk, [](std::size_t i, ImuSample& s) {
    if (i % 20 == 0) s.angular_rate_radps.x() = 1e30;
    if (i % 20 == 10) s.specific_force_mps2.z() = -1e30;
    return true;
  }));
  EXPECT_LT(end_error(d.poses, walk), 1.0);
}

// Tumbling in free fall for a second, impact, and walking on.
TEST(FootBadInput, RecoversFromFreeFall) {
  const FootWalk walk = walk_foot({});
  const Damaged d(damage(walk, [](std::size_t i, ImuSample& s) {
    s.specific_force_mps2 = i > 190 ? Vector3d(150.0, -150.0, 150.0) : Vector3d(0.05, 0.0, 0.1);
    s.angular_rate_radps = {20.0 * std::sin(0.1 * double(i)), 15.0, -10.0};
    return true;
  }));
  // At rest at the end: zero velocity and correct tilt.
  const FootPose& end = d.poses.back();
  EXPECT_LT(end.velocity_mps.norm(), 0.05);
  const Vector3d up = end.q_world_foot * d.tracker.filter().force_bias() * 0.0 +
                      end.q_world_foot * (walk.samples.back().specific_force_mps2 -
                                          d.tracker.filter().force_bias());
  EXPECT_NEAR(up.z(), 9.80665, 0.05);
}

TEST(FootBadInput, WaitsForGravityBeforeItStarts) {
  FootTracker tracker;
  for (int i = 0; i < 400; ++i)
    tracker.add({LogTime::from_nanoseconds(i * 5'000'000), {1.0, 2.0, 3.0}, {0.1, 0.0, 0.0}});
  EXPECT_FALSE(tracker.ready());
  EXPECT_EQ(tracker.report().stances, 0U);
}

TEST(FootBadInput, StaysFiniteOnRandomInput) {
  Rng rng(5);
  const FootWalk walk = walk_foot({});
  FootTracker tracker;
  for (std::size_t i = 0; i < 60000; ++i) {
    ImuSample s = walk.samples[i % walk.samples.size()];
    s.time = LogTime::from_nanoseconds(static_cast<std::int64_t>(i) * 5'000'000 +
                                       static_cast<std::int64_t>(rng.below(8'000'000)));
    const auto kind = rng.below(30);
    const auto axis = [&] { return static_cast<int>(rng.below(3)); };
    const double wild = kind == 0   ? std::numeric_limits<double>::infinity()
                        : kind == 1 ? 1e300 * rng.normal()
                        : kind == 2 ? 100.0 * rng.normal()
                                    : 0.0;
    if (kind < 3) s.specific_force_mps2[axis()] = wild;
    if (kind == 3) s.angular_rate_radps[axis()] = 30.0 * rng.normal();
    if (rng.below(3000) == 0) s.time += std::chrono::seconds(rng.below(20));
    tracker.add(s, [&](const FootPose& p) {
      ASSERT_TRUE(p.position_m.allFinite()) << i;
      ASSERT_TRUE(tracker.filter().covariance().allFinite()) << i;
    });
  }
}

}  // namespace
}  // namespace wayfare
