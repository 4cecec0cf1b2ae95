// On data from the filter's model its covariance matches its errors.

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

/// Parameters and a motion with exactly these.
struct Matched {
  AhrsParameters parameters;
  MotionOptions motion;
};

Matched matched(std::uint64_t seed) {
  Matched m;
  AhrsParameters& p = m.parameters;
  p.rate_noise = 0.2 * kDegree;
  p.rate_scale_noise = 0.0;
  p.bias_walk = 1e-6;
  p.bias_sigma = 0.5 * kDegree;
  p.force_noise = 0.02;
  p.velocity_time_s = 0.2;
  p.velocity_density = 0.3;
  p.heading_density = 2.0 * kDegree;
  p.magnetometer_delay_sigma_s = 0.01;
  MotionOptions& o = m.motion;
  o.rate_hz = 50.0;
  o.duration_s = 200.0;
  o.velocity_time_s = 0.2;
  o.velocity_sigma = 0.3 / std::sqrt(0.4);
  o.rate_density = p.rate_noise;
  o.force_density = p.force_noise;
  o.heading_density = p.heading_density;
  o.seed = seed;
  Rng rng(seed + 100);
  o.bias_radps = testing::normal3(rng, p.bias_sigma);
  o.rest_s = 0.05;  // for an initial tilt within the filter's assumption
  // Nearly horizontal: the filter neglects heading errors from tilt.
  o.field_enu_uT = {0.0, 40.0, -5.0};
  return m;
}

TEST(AhrsConsistency, InnovationsHaveTheirVariance) {
  double velocity = 0.0, heading = 0.0;
  int n_velocity = 0, n_heading = 0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Matched m = matched(seed);
    const Motion motion = testing::simulate(m.motion);
    Ahrs<frame::Enu> ahrs(m.parameters);
    for (std::size_t i = 0; i < motion.samples.size(); ++i) {
      const MargUpdateStatus status = ahrs.add(motion.samples[i]);
      if (i < 500) continue;  // ten seconds to converge
      const auto nis = ahrs.nis();
      velocity += nis.velocity_east + nis.velocity_north;
      n_velocity += 2;
      if (status.magnetometer != UpdateStatus::used) continue;
      heading += nis.heading;
      ++n_heading;
    }
  }
  // χ² with n degrees of freedom has mean n and standard deviation √(2n). n = 95 000 and 47 500;
  // five deviations are 2.3 and 3.2 %.
  ASSERT_GT(n_velocity, 90000);
  ASSERT_GT(n_heading, 45000);
  EXPECT_NEAR(velocity / n_velocity, 1.0, 5.0 * std::sqrt(2.0 / n_velocity));
  EXPECT_NEAR(heading / n_heading, 1.0, 5.0 * std::sqrt(2.0 / n_heading));
}

TEST(AhrsConsistency, AttitudeErrorsHaveTheirCovariance) {
  double nees = 0.0, bias_nees = 0.0;
  int count = 0;
  for (std::uint64_t seed = 11; seed <= 30; ++seed) {
    Matched m = matched(seed);
    m.motion.duration_s = 60.0;
    const Motion motion = testing::simulate(m.motion);
    Ahrs<frame::Enu> ahrs(m.parameters);
    for (std::size_t i = 0; i < motion.samples.size(); ++i) {
      ahrs.add(motion.samples[i]);
      if (i % 1000 != 999) continue;  // 20 s apart: nearly independent
      const Eigen::Vector3d error = ahrs.q_world_body().minus(motion.q_enu_body[i]);
      nees += error.dot(ahrs.body_covariance().llt().solve(error));
      const Eigen::Vector3d off = ahrs.gyro_bias_radps() - m.motion.bias_radps;
      bias_nees += off.cwiseQuotient(ahrs.gyro_bias_sigma_radps()).squaredNorm();
      ++count;
    }
  }
  // Three degrees of freedom each: χ² with 3·60 = 180 has 99.9 % of its values within 122 … 252;
  // the common initial heading and the constant bias correlate the samples.
  ASSERT_EQ(count, 60);
  EXPECT_GT(nees, 110.0);
  EXPECT_LT(nees, 280.0);
  EXPECT_GT(bias_nees, 90.0);
  EXPECT_LT(bias_nees, 320.0);
}

TEST(AhrsConsistency, HeadingVarianceIsThatOfTheCovariance) {
  const Motion motion = testing::simulate(matched(3).motion);
  Ahrs<frame::Ned> ahrs;
  for (std::size_t i = 0; i < 2000; ++i) {
    ahrs.add(motion.samples[i]);
    const double expected = ahrs.world_covariance()(2, 2);
    ASSERT_NEAR(ahrs.heading_variance(), expected, 1e-12 * expected) << i;
  }
}

TEST(AhrsConsistency, BodyAndWorldCovarianceAreTheSame) {
  const Motion motion = testing::simulate(matched(3).motion);
  Ahrs<frame::Ned> ned;
  Ahrs<frame::Enu> enu;
  for (std::size_t i = 0; i < 2000; ++i) ned.add(motion.samples[i]), enu.add(motion.samples[i]);
  const Eigen::Matrix3d r = ned.q_world_body().matrix();
  EXPECT_LT((r * ned.body_covariance() * r.transpose() - ned.world_covariance()).norm(), 1e-15);
  // North is the first axis of NED and the second of ENU.
  EXPECT_NEAR(ned.world_covariance()(0, 0), enu.world_covariance()(1, 1), 1e-15);
  EXPECT_NEAR(ned.world_covariance()(2, 2), enu.world_covariance()(2, 2), 1e-15);
  EXPECT_NEAR(ned.world_covariance()(0, 2), -enu.world_covariance()(1, 2), 1e-15);
  EXPECT_LT((ned.body_covariance() - enu.body_covariance()).norm(), 1e-15);
}

TEST(AhrsConsistency, BiasesConvergeAtRestAndInMotion) {
  for (const double turn : {0.0, 1.0}) {
    MotionOptions o = matched(5).motion;
    o.turn_radps = turn;
    o.velocity_sigma = turn > 0.0 ? 0.2 : 0.0;
    o.rate_density = 0.01 * kDegree;
    o.heading_density = 0.0;
    o.field_noise_uT = 0.3;
    o.bias_radps = {0.01, -0.015, 0.012};  // 0.6 to 0.9 °/s
    const Motion motion = testing::simulate(o);
    Ahrs<frame::Enu> ahrs;
    for (const MargSample& s : motion.samples) ahrs.add(s);
    EXPECT_LT((ahrs.gyro_bias_radps() - o.bias_radps).norm(), (turn > 0.0 ? 0.2 : 0.01) * kDegree);
  }
}

TEST(AhrsConsistency, EstimatesTheMagnetometerDelay) {
  MotionOptions o = matched(6).motion;
  o.rate_hz = 100.0;
  o.heading_density = 0.0;
  o.field_noise_uT = 0.5;
  o.magnetometer_delay_s = 0.03;
  o.turn_radps = 2.0;
  const Motion motion = testing::simulate(o);
  AhrsParameters estimating;
  estimating.heading_density = 3.0 * kDegree;
  AhrsParameters fixed = estimating;
  fixed.magnetometer_delay_sigma_s = 0.0;
  Ahrs<frame::Enu> with(estimating), without(fixed);
  eval::AttitudeRmse error_with, error_without;
  for (std::size_t i = 0; i < motion.samples.size(); ++i) {
    with.add(motion.samples[i]), without.add(motion.samples[i]);
    if (i < motion.samples.size() / 2) continue;
    error_with.add(eval::attitude_error(with.q_world_body(), motion.q_enu_body[i]));
    error_without.add(eval::attitude_error(without.q_world_body(), motion.q_enu_body[i]));
  }
  EXPECT_NEAR(with.magnetometer_delay_s(), 0.03, 0.004);
  EXPECT_EQ(without.magnetometer_delay_s(), 0.0);
  EXPECT_LT(error_with.value().heading.radians(), 0.7 * error_without.value().heading.radians());
}

}  // namespace
}  // namespace wayfare
