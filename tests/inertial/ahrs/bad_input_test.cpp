// Faulty readings: the filter stays finite, recovers, and reports what it rejected.

#include <cmath>
#include <functional>
#include <limits>

#include <gtest/gtest.h>

#include <wayfare/eval/trajectory_error.hpp>
#include <wayfare/inertial/ahrs.hpp>
#include "motion.hpp"

namespace wayfare {
namespace {

using testing::kDegree;
using testing::kGravity;
using testing::Motion;
using testing::MotionOptions;

constexpr double kRate_hz = 100.0;

Motion calm_motion() {
  MotionOptions o;
  o.rate_hz = kRate_hz;
  o.duration_s = 90.0;
  o.rest_s = 3.0;
  o.turn_radps = 0.7;
  o.velocity_sigma = 0.2;
  o.bias_radps = {0.003, -0.002, 0.001};
  o.rate_density = 0.02 * kDegree;
  o.force_density = 0.005;
  o.field_noise_uT = 0.3;
  return testing::simulate(o);
}

struct Outcome {
  double at_end_deg = 0.0;  ///< root mean square over the last 10 s
  AhrsReport report;
  bool finite = true;
};

/// Runs the motion with each sample modified by `corrupt`, which returns false to drop it.
Outcome run_with(const std::function<bool(double, MargSample&)>& corrupt,
                 Motion motion = calm_motion(), const AhrsParameters& parameters = {}) {
  Ahrs<frame::Enu> ahrs(parameters);
  Outcome outcome;
  eval::AttitudeRmse rmse;
  const auto n = motion.samples.size();
  for (std::size_t i = 0; i < n; ++i) {
    const double t = static_cast<double>(i) / kRate_hz;
    if (!corrupt(t, motion.samples[i])) continue;
    ahrs.add(motion.samples[i]);
    outcome.finite = outcome.finite && ahrs.q_world_body().quaternion().coeffs().allFinite() &&
                     ahrs.world_covariance().allFinite() && ahrs.gyro_bias_radps().allFinite();
    if (i + static_cast<std::size_t>(10 * kRate_hz) >= n)
      rmse.add(eval::attitude_error(ahrs.q_world_body(), motion.q_enu_body[i]));
  }
  outcome.at_end_deg = rmse.value().total.degrees();
  outcome.report = ahrs.report();
  return outcome;
}

bool within(double t, double from, double to) { return t >= from && t < to; }

TEST(AhrsBadInput, BaselineWithoutFaults) {
  const Outcome o = run_with([](double, MargSample&) { return true; });
  EXPECT_TRUE(o.finite);
  EXPECT_LT(o.at_end_deg, 1.0);
  EXPECT_EQ(o.report.gyro.used, 9000U);
  EXPECT_EQ(o.report.magnetometer.disturbed, 0U);
  EXPECT_EQ(o.report.restarts + o.report.level_resets + o.report.heading_resets, 0U);
}

TEST(AhrsBadInput, Dropouts) {
  // All sensors silent for 0.3 s, then for 5 s, while turning.
  const Outcome o = run_with(
      [](double t, MargSample&) { return !within(t, 30.0, 30.3) && !within(t, 40.0, 45.0); });
  EXPECT_TRUE(o.finite);
  EXPECT_LT(o.at_end_deg, 2.0);
  EXPECT_EQ(o.report.restarts, 1U);  // only the longer gap
}

TEST(AhrsBadInput, OneSensorSilent) {
  const auto silent = [](Eigen::Vector3d MargSample::*sensor) {
    return run_with([sensor](double t, MargSample& s) {
      if (within(t, 30.0, 40.0)) (s.*sensor).setConstant(MargSample::kNone);
      return true;
    });
  };
  const Outcome gyro = silent(&MargSample::angular_rate_radps);
  EXPECT_EQ(gyro.report.gyro.missing, 1000U);
  EXPECT_GT(gyro.report.accelerometer.waiting, 950U);  // no gyro reading near their time
  EXPECT_LT(gyro.at_end_deg, 2.0);
  const Outcome force = silent(&MargSample::specific_force_mps2);
  EXPECT_EQ(force.report.accelerometer.missing, 1000U);
  EXPECT_LT(force.at_end_deg, 1.0);
  const Outcome field = silent(&MargSample::magnetic_field_uT);
  EXPECT_EQ(field.report.magnetometer.missing, 1000U);
  EXPECT_LT(field.at_end_deg, 1.0);
  EXPECT_TRUE(gyro.finite && force.finite && field.finite);
}

TEST(AhrsBadInput, SaturatedSensors) {
  // For 20 s the gyro saturates: 3 rad/s read as 2.5.
  MotionOptions fast;
  fast.rate_hz = kRate_hz;
  fast.duration_s = 90.0;
  fast.rest_s = 3.0;
  fast.turn_radps = 3.0;
  AhrsParameters p;
  p.rate_range = 2.5;
  const Outcome o = run_with(
      [](double t, MargSample& s) {
        if (within(t, 30.0, 50.0))
          s.angular_rate_radps = s.angular_rate_radps.cwiseMax(-2.5).cwiseMin(2.5);
        return true;
      },
      testing::simulate(fast), p);
  EXPECT_TRUE(o.finite);
  EXPECT_GT(o.report.gyro.saturated, 500U);
  EXPECT_LT(o.at_end_deg, 3.0);
}

TEST(AhrsBadInput, HugeNumbers) {
  const Outcome o = run_with([](double t, MargSample& s) {
    if (within(t, 30.0, 31.0)) s.angular_rate_radps.setConstant(1e30);
    if (within(t, 40.0, 41.0)) s.specific_force_mps2.setConstant(-1e300);
    if (within(t, 50.0, 51.0)) s.magnetic_field_uT.setConstant(1e200);
    return true;
  });
  EXPECT_TRUE(o.finite);
  EXPECT_LT(o.at_end_deg, 2.0);
  EXPECT_EQ(o.report.gyro.saturated, 100U);
  EXPECT_EQ(o.report.accelerometer.saturated, 100U);
}

TEST(AhrsBadInput, TimeStampsOutOfOrder) {
  // A sample out of order, a clock set back by a minute permanently, and one stamped years ahead.
  const Outcome order = run_with([](double t, MargSample& s) {
    if (std::fmod(t, 1.0) < 0.005) s.time = s.time - std::chrono::milliseconds(25);
    return true;
  });
  EXPECT_TRUE(order.finite);
  EXPECT_NEAR(static_cast<double>(order.report.gyro.late), 89.0, 2.0);
  EXPECT_LT(order.at_end_deg, 1.0);
  EXPECT_EQ(order.report.restarts, 0U);

  const Outcome back = run_with([](double t, MargSample& s) {
    if (t >= 40.0) s.time = s.time - std::chrono::seconds(60);
    return true;
  });
  EXPECT_TRUE(back.finite);
  EXPECT_LT(back.at_end_deg, 2.0);
  EXPECT_NEAR(static_cast<double>(back.report.gyro.late), 100.0, 2.0);  // its patience is 1 s
  EXPECT_EQ(back.report.restarts, 1U);

  const Outcome ahead = run_with([](double t, MargSample& s) {
    if (within(t, 40.0, 40.005)) s.time = s.time + std::chrono::hours(20000);
    return true;
  });
  EXPECT_TRUE(ahead.finite);
  EXPECT_LT(ahead.at_end_deg, 2.0);
}

TEST(AhrsBadInput, MagnetNearby) {
  // A magnet's 60 µT, fixed to the surroundings, for 20 s.
  const Motion motion = calm_motion();
  Motion disturbed = motion;
  const Eigen::Vector3d magnet(60.0, 20.0, 30.0);
  const Outcome o = run_with(
      [&, i = std::size_t{0}](double t, MargSample& s) mutable {
        const SO3d& q = motion.q_enu_body[i++];
        if (within(t, 40.0, 60.0)) s.magnetic_field_uT += q.inverse() * magnet;
        return true;
      },
      disturbed);
  EXPECT_TRUE(o.finite);
  EXPECT_GT(o.report.magnetometer.disturbed, 1900U);
  EXPECT_LT(o.at_end_deg, 1.5);
}

TEST(AhrsBadInput, LearnsAnotherField) {
  // Indoors from then on: different strength and dip, same north.
  const Motion motion = calm_motion();
  const Outcome o = run_with(
      [&, i = std::size_t{0}](double t, MargSample& s) mutable {
        const SO3d& q = motion.q_enu_body[i++];
        if (t >= 30.0) s.magnetic_field_uT = q.inverse() * Eigen::Vector3d(0.0, 30.0, -30.0);
        return true;
      },
      motion);
  EXPECT_GT(o.report.magnetometer.disturbed, 1500U);
  EXPECT_LT(o.report.magnetometer.disturbed, 4500U);  // 20 s of turning
  EXPECT_LT(o.at_end_deg, 1.5);
}

TEST(AhrsBadInput, FreeFallAndLanding) {
  // Zero specific force for 0.6 s, then a shock beyond the accelerometer's range.
  const Outcome o = run_with([](double t, MargSample& s) {
    if (within(t, 40.0, 40.6)) s.specific_force_mps2 *= 0.01;
    if (within(t, 40.6, 40.62)) s.specific_force_mps2.setConstant(156.96);
    return true;
  });
  EXPECT_TRUE(o.finite);
  EXPECT_EQ(o.report.accelerometer.saturated, 2U);
  EXPECT_LT(o.at_end_deg, 1.0);
}

TEST(AhrsBadInput, ThrownPhone) {
  // In the air for 1 s, tumbling beyond the gyro's range; caught in a different attitude.
  MotionOptions before, after;
  before.rate_hz = after.rate_hz = kRate_hz;
  before.duration_s = 20.0;
  after.duration_s = 40.0;
  before.rest_s = 3.0;
  before.turn_radps = after.turn_radps = 0.5;
  Motion motion = testing::simulate(before);
  const LogTime thrown = motion.samples.back().time;
  for (int i = 1; i <= 100; ++i) {
    MargSample s;
    s.time = thrown + from_seconds(i / kRate_hz);
    s.angular_rate_radps = {34.9, -34.9, 34.9};  // clipped
    s.specific_force_mps2 = {0.1, -0.1, 0.05};
    s.magnetic_field_uT = SO3d::exp({0.5 * i, -0.3 * i, 0.0}) * Eigen::Vector3d(0, 18, -42);
    motion.samples.push_back(s);
    motion.q_enu_body.push_back(SO3d());
  }
  after.start = SO3d::exp({2.0, 1.0, -1.5});
  const Motion caught = testing::simulate(after);
  const Duration shift = thrown - caught.samples.front().time + from_seconds(1.01);
  for (std::size_t i = 0; i < caught.samples.size(); ++i) {
    MargSample s = caught.samples[i];
    s.time += shift;
    if (i < 3) s.specific_force_mps2 *= 15.0;
    motion.samples.push_back(s);
    motion.q_enu_body.push_back(caught.q_enu_body[i]);
  }
  const Outcome o = run_with([](double, MargSample&) { return true; }, motion);
  EXPECT_TRUE(o.finite);
  EXPECT_EQ(o.report.gyro.saturated, 100U);
  EXPECT_LT(o.at_end_deg, 3.0);
}

TEST(AhrsBadInput, StaysFiniteOnRandomInput) {
  Rng rng(5);
  Ahrs<frame::Ned, float> ahrs;
  LogTime time;
  const auto anything = [&]() -> double {
    switch (rng.below(8)) {
      case 0:
        return std::numeric_limits<double>::quiet_NaN();
      case 1:
        return std::numeric_limits<double>::infinity();
      case 2:
        return rng.normal() * 1e30;
      case 3:
        return 0.0;
      case 4:
        return rng.normal() * 1e-30;
      default:
        return rng.normal() * 30.0;
    }
  };
  for (int i = 0; i < 200000; ++i) {
    time += std::chrono::milliseconds(static_cast<int>(rng.below(20)) - 3);
    if (rng.below(1000) == 0) time += std::chrono::seconds(static_cast<int>(rng.below(100)) - 50);
    MargSample s;
    s.time = time;
    for (auto* v : {&s.angular_rate_radps, &s.specific_force_mps2, &s.magnetic_field_uT})
      *v = rng.below(3) == 0 ? Eigen::Vector3d(anything(), anything(), anything())
                             : testing::normal3(rng, 20.0);
    ahrs.add(s);
    ASSERT_TRUE(ahrs.q_world_body().quaternion().coeffs().allFinite()) << i;
    ASSERT_TRUE(ahrs.world_covariance().allFinite()) << i;
    ASSERT_TRUE(ahrs.gyro_bias_radps().allFinite()) << i;
    ASSERT_GE(ahrs.world_covariance().diagonal().minCoeff(), 0.0F) << i;
    ASSERT_NEAR(ahrs.q_world_body().quaternion().norm(), 1.0F, 1e-3F) << i;
  }
}

}  // namespace
}  // namespace wayfare
