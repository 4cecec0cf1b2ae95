// The attitude does not depend on sensor rates, frame, precision or use of the magnetometer.

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include <wayfare/eval/trajectory_error.hpp>
#include <wayfare/inertial/ahrs.hpp>
#include "motion.hpp"

namespace wayfare {
namespace {

using testing::kDegree;
using testing::Motion;
using testing::MotionOptions;

MotionOptions smooth_motion(double rate_hz) {
  MotionOptions o;
  o.rate_hz = rate_hz;
  o.duration_s = 40.0;
  o.rest_s = 2.0;
  o.turn_radps = 0.8;
  return o;
}

TEST(AhrsRates, SameMotionAtDifferentRates) {
  // Piecewise constant rates at different periods differ by half a period of rotation; with 0.8
  // rad/s and 0.8·1.3 rad/s² that is below 0.1° from 50 Hz up.
  for (const double rate_hz : {50.0, 100.0, 200.0, 800.0}) {
    const Motion motion = testing::simulate(smooth_motion(rate_hz));
    Ahrs<frame::Enu> ahrs;
    eval::AttitudeRmse rmse;
    for (std::size_t i = 0; i < motion.samples.size(); ++i) {
      ahrs.add(motion.samples[i]);
      if (static_cast<double>(i) > 5.0 * rate_hz)
        rmse.add(eval::attitude_error(ahrs.q_world_body(), motion.q_enu_body[i]));
    }
    EXPECT_LT(rmse.value().total.degrees(), 0.2) << rate_hz;
  }
}

TEST(AhrsRates, UncertaintyDoesNotDependOnTheRate) {
  // Densities, not variances per sample: equal uncertainty after equal time at rest.
  Eigen::Vector3d sigma[2];
  for (const int k : {0, 1}) {
    MotionOptions o = smooth_motion(k == 0 ? 50.0 : 400.0);
    o.rest_s = 100.0;
    o.duration_s = 10.0;
    AhrsParameters p;
    p.rest_time_s = 1e9;  // disabled: rest is evaluated at discrete times, which differ
    Ahrs<frame::Enu> ahrs(p);
    for (const MargSample& s : testing::simulate(o).samples) ahrs.add(s);
    sigma[k] = ahrs.world_covariance().diagonal().cwiseSqrt();
  }
  EXPECT_LT(sigma[0].cwiseQuotient(sigma[1]).array().log().abs().maxCoeff(), 0.05);
}

TEST(AhrsRates, SeparateIrregularSensors) {
  // Gyro at 200 Hz with jittering times, accelerometer near 67 Hz, magnetometer near 20 Hz.
  MotionOptions o = smooth_motion(1000.0);
  o.rate_density = 0.02 * kDegree;
  o.field_noise_uT = 0.3;
  const Motion motion = testing::simulate(o);
  Rng rng(9);
  Ahrs<frame::Ned> ahrs;
  eval::AttitudeRmse rmse;
  Eigen::Vector3d turned = Eigen::Vector3d::Zero(), measured = Eigen::Vector3d::Zero();
  int next_gyro = 5, since_gyro = 0, next_force = 15, since_force = 0, next_field = 50;
  for (int i = 0; i < static_cast<int>(motion.samples.size()); ++i) {
    const MargSample& s = motion.samples[static_cast<std::size_t>(i)];
    turned += s.angular_rate_radps;
    measured += s.specific_force_mps2;
    ++since_gyro, ++since_force;
    if (i == next_gyro) {
      ahrs.add_rate(s.time, turned / since_gyro);
      turned.setZero();
      since_gyro = 0;
      next_gyro += 3 + static_cast<int>(rng.below(5));
      if (i > 5000 && ahrs.ready()) {
        const SO3d truth = rotation_from_enu<frame::Ned, double>() *
                           motion.q_enu_body[static_cast<std::size_t>(i)];
        rmse.add(eval::attitude_error(ahrs.q_world_body(), truth));
      }
    }
    if (i == next_force) {
      ahrs.add_force(s.time, measured / since_force);
      measured.setZero();
      since_force = 0;
      next_force += 12 + static_cast<int>(rng.below(7));
    }
    if (i == next_field) {
      ahrs.add_field(s.time, s.magnetic_field_uT);
      next_field += 30 + static_cast<int>(rng.below(41));
    }
  }
  EXPECT_LT(rmse.value().total.degrees(), 0.5);
  EXPECT_EQ(ahrs.report().gyro.late + ahrs.report().accelerometer.late, 0U);
}

TEST(AhrsRates, NedAndEnuAgree) {
  const Motion motion = testing::simulate(smooth_motion(100.0));
  Ahrs<frame::Ned> ned;
  Ahrs<frame::Enu> enu;
  for (const MargSample& s : motion.samples) ned.add(s), enu.add(s);
  const Eigen::Vector3d forward = enu.q_world_body().matrix().col(0);
  const Eigen::Vector3d expected(forward.y(), forward.x(), -forward.z());
  EXPECT_LT((ned.q_world_body().matrix().col(0) - expected).norm(), 1e-12);
  EXPECT_NEAR(compass_of_x<frame::Ned>(ned.q_world_body()).radians(),
              compass_of_x<frame::Enu>(enu.q_world_body()).radians(), 1e-12);
}

TEST(AhrsRates, FloatStaysNearDouble) {
  MotionOptions o = smooth_motion(100.0);
  o.duration_s = 600.0;
  o.rate_density = 0.1 * kDegree;
  o.velocity_sigma = 0.2;
  const Motion motion = testing::simulate(o);
  Ahrs<frame::Enu, double> full;
  Ahrs<frame::Enu, float> half;
  double worst = 0.0;
  for (const MargSample& s : motion.samples) {
    full.add(s), half.add(s);
    worst = std::max(worst, half.q_world_body().cast<double>().minus(full.q_world_body()).norm());
  }
  EXPECT_LT(worst, 0.1 * kDegree);
}

TEST(AhrsRates, DeclinationGivesTrueNorth) {
  MotionOptions o = smooth_motion(100.0);
  const SO3d east = SO3d::exp({0.0, 0.0, -10.0 * kDegree});  // clockwise
  o.field_enu_uT = east * o.field_enu_uT;
  const Motion motion = testing::simulate(o);
  AhrsParameters p;
  p.declination = Angle::degrees(10.0);
  Ahrs<frame::Enu> with(p), without;
  for (const MargSample& s : motion.samples) with.add(s), without.add(s);
  const SO3d& truth = motion.q_enu_body.back();
  EXPECT_LT(eval::attitude_error(with.q_world_body(), truth).heading.degrees(), 0.2);
  EXPECT_NEAR(eval::attitude_error(without.q_world_body(), truth).heading.degrees(), 10.0, 0.2);
}

TEST(AhrsRates, WithoutMagnetometerTheHeadingIsRelative) {
  const Motion motion = testing::simulate(smooth_motion(100.0));
  AhrsParameters p;
  p.use_magnetometer = false;
  Ahrs<frame::Enu> ahrs(p);
  for (std::size_t i = 0; i < 100; ++i) ahrs.add(motion.samples[i]);
  EXPECT_FALSE(ahrs.heading_known());
  EXPECT_LT(ahrs.world_covariance()(2, 2), 1e-3);
  const Angle truth = compass_of_x<frame::Enu>(motion.q_enu_body[99]);
  ahrs.set_compass(truth, Angle::degrees(1.0));
  EXPECT_TRUE(ahrs.heading_known());
  EXPECT_NEAR(ahrs.world_covariance()(2, 2), kDegree * kDegree, 1e-12);
  for (std::size_t i = 100; i < motion.samples.size(); ++i)
    EXPECT_EQ(ahrs.add(motion.samples[i]).magnetometer, UpdateStatus::missing);
  EXPECT_LT(eval::attitude_error(ahrs.q_world_body(), motion.q_enu_body.back()).total.degrees(),
            1.0);
}

TEST(AhrsRates, StartsInMotion) {
  MotionOptions o = smooth_motion(100.0);
  o.rest_s = 0.0;
  o.turn_radps = 2.0;
  o.velocity_sigma = 0.3;  // with accelerations of 5 m/s² root mean square
  o.velocity_time_s = 0.5;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    o.seed = seed;
    const Motion motion = testing::simulate(o);
    Ahrs<frame::Enu> ahrs;
    for (std::size_t i = 0; i < 1500; ++i) ahrs.add(motion.samples[i]);
    const auto error = eval::attitude_error(ahrs.q_world_body(), motion.q_enu_body[1499]);
    EXPECT_LT(error.inclination.degrees(), 4.0) << seed;
    EXPECT_LT(error.heading.degrees(), 15.0) << seed;
  }
}

}  // namespace
}  // namespace wayfare
