// Motion models and the radar's ego-velocity with what wheels, gyros and radars never measure.

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/motion/differential_drive_model.hpp>
#include <wayfare/motion/radar_velocity.hpp>

#include "abuse/abuse.hpp"

namespace wayfare::tests {
namespace {

TEST(MotionAbuse, DistancesFromNoneToBillionsHaveACovariance) {
  const DifferentialDriveModel wheels;
  const GyroMotion gyro;
  for (const double d : {0.0, kTiny, -0.0, 1.0, -1.0, 1e9, -1e9}) {
    for (const auto& motion : {wheels(d, d), wheels(d, -d), wheels(0.0, d), gyro(d, 1.0, 0.1),
                               gyro(d, -1.0, -0.1), gyro(0.0, d, 1.0)}) {
      EXPECT_TRUE(motion.mean.translation().allFinite()) << d;
      EXPECT_TRUE(motion.covariance.allFinite()) << d;
      EXPECT_GE(motion.covariance.diagonal().minCoeff(), 0.0) << d;
      EXPECT_EQ(motion.covariance, motion.covariance.transpose());
    }
    const Eigen::Vector3d sigma = sigma_of(SE2d(d, d, Angle::radians(d)), MotionNoise{});
    EXPECT_TRUE(sigma.allFinite());
    EXPECT_GT(sigma.minCoeff(), 0.0);
  }
}

TEST(MotionAbuse, WhatIsNotMeasuredDoesNotPassTheFusion) {
  const Gaussian<SE2d> good = DifferentialDriveModel{}(1.0, 1.1);
  for (const double odd : kNotFinite) {
    EXPECT_FALSE(fuse(DifferentialDriveModel{}(odd, 1.0), good)) << odd;
    EXPECT_FALSE(fuse(good, GyroMotion{}(1.0, odd, 0.1))) << odd;
    EXPECT_FALSE(fuse(good, GyroMotion{}(1.0, 1.0, odd))) << odd;
  }
  DifferentialDriveModel no_base;
  no_base.wheel_base_m = 0.0;
  EXPECT_FALSE(fuse(no_base(1.0, 1.1), good));
  EXPECT_FALSE(fuse(no_base(1.0, 1.0), good));
  Rng rng(1);
  const SE2d lost = MotionSampler(no_base(1.0, 1.0))(rng);
  EXPECT_FALSE(lost.translation().allFinite() && std::isfinite(lost.heading().radians()));
}

TEST(MotionAbuse, WithoutAnyNoiseTheSampleIsTheMean) {
  DifferentialDriveModel exact;
  exact.slip_m_per_sqrt_m = 0.0;
  exact.ground = {0.0, 0.0, 0.0, 0.0};
  const Gaussian<SE2d> motion = exact(1.0, 1.2);
  EXPECT_TRUE(motion.covariance.isZero(0.0));
  Rng rng(2);
  expect_value_semantics(MotionSampler(motion), [&](MotionSampler& s) { return s(rng).x(); });
  EXPECT_EQ(MotionSampler(motion)(rng).minus(motion.mean).norm(), 0.0);
  EXPECT_FALSE(fuse(motion, motion));
}

/// A frame of static points seen while moving with `v`.
RadarScan frame_of(std::size_t n, const Eigen::Vector3d& v, Rng& rng) {
  RadarScan scan;
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector3d p(rng.uniform(0.5, 5.0), rng.uniform(-4.0, 4.0), rng.uniform(-2.0, 2.0));
    scan.points.push_back({static_cast<float>(p.x()), static_cast<float>(p.y()),
                           static_cast<float>(p.z()), static_cast<float>(-v.dot(p.normalized())),
                           20.0F});
  }
  return scan;
}

TEST(RadarVelocityAbuse, PointsThatAreNoPointsAreIgnored) {
  constexpr float kNanF = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInfF = std::numeric_limits<float>::infinity();
  Rng rng(3);
  const Eigen::Vector3d v(1.0, 0.3, 0.1);
  RadarScan scan = frame_of(30, v, rng);
  for (const double min_range : {-1.0, 0.0, 0.25})
    for (const RadarPoint& odd :
         {RadarPoint{kNanF, 1, 0, 1, 20}, RadarPoint{1, kInfF, 0, 1, 20},
          RadarPoint{1, 1, 0, kNanF, 20}, RadarPoint{1, 1, 0, -kInfF, 20},
          RadarPoint{1, 1, 0, 1, kNanF}, RadarPoint{0, 0, 0, 0, 20}, RadarPoint{0, 0, 0, 3, 20}}) {
      RadarScan with = scan;
      with.points.insert(with.points.begin(), 3, odd);
      RadarVelocityOptions options;
      options.min_range_m = min_range;
      const auto result = radar_velocity(with, Rng(4), options);
      ASSERT_TRUE(result);
      EXPECT_LT((result->velocity_m_s - v).norm(), 1e-5);
      EXPECT_EQ(result->points, 30U);
      EXPECT_FALSE(result->inlier[0]);
    }
}

TEST(RadarVelocityAbuse, FramesWithoutDirectionsAreErrors) {
  Rng rng(5);
  EXPECT_FALSE(radar_velocity({}, Rng(1)));
  EXPECT_FALSE(radar_velocity(frame_of(3, {1, 0, 0}, rng), Rng(1)));
  RadarScan same;
  same.points.assign(50, {1, 0, 0, -1, 20});
  EXPECT_FALSE(radar_velocity(same, Rng(1)));
  RadarVelocityOptions options;
  for (double* number : {&options.inlier_m_s, &options.min_snr_db, &options.min_range_m}) {
    const double before = *number;
    *number = kNan;
    EXPECT_FALSE(radar_velocity(frame_of(30, {1, 0, 0}, rng), Rng(1), options));
    *number = before;
  }
  options.draws = 0;
  EXPECT_TRUE(radar_velocity(frame_of(30, {0, 0, 0}, rng), Rng(1), options));
}

TEST(RadarVelocityAbuse, AnyFloatsGiveAFiniteVelocityOrAnError) {
  Rng rng(6);
  for (int run = 0; run < 1500; ++run) {
    RadarScan scan = frame_of(rng.below(12), {rng.normal(), rng.normal(), 0}, rng);
    for (RadarPoint& p : scan.points)
      for (float* x : {&p.x_m, &p.y_m, &p.z_m, &p.doppler_m_s})
        if (rng.below(6) == 0) *x = std::bit_cast<float>(static_cast<std::uint32_t>(rng() >> 32));
    RadarVelocityOptions options;
    options.plane = rng.below(2) == 0;
    options.min_range_m = rng.below(2) == 0 ? 0.0 : 0.25;
    options.inlier_m_s = std::pow(10.0, rng.uniform(-2.0, 30.0));
    options.draws = 20;
    const auto result = radar_velocity(scan, Rng(7), options);
    if (!result) continue;
    ASSERT_TRUE(result->velocity_m_s.allFinite()) << run;
    ASSERT_TRUE(result->covariance.allFinite()) << run;
    ASSERT_LE(result->inliers, result->points);
    ASSERT_EQ(result->inlier.size(), scan.points.size());
  }
}

TEST(MotionAbuse, TwoThreadsMoveTheSame) {
  const auto both = in_two_threads([](int) {
    Rng rng(8);
    std::vector<double> all;
    for (int i = 0; i < 100; ++i) {
      const auto velocity = radar_velocity(frame_of(20, {1, 0.2, 0}, rng), rng.stream(1));
      all.push_back(velocity ? velocity->velocity_m_s.x() : -1.0);
      all.push_back(MotionSampler(DifferentialDriveModel{}(rng.normal(), rng.normal()))(rng).x());
    }
    return all;
  });
  EXPECT_EQ(both[0], both[1]);
}

}  // namespace
}  // namespace wayfare::tests
