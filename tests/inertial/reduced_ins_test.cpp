// Navigation with one gyro and wheels, in latitude and longitude and in a plane; error growth.

#include <wayfare/inertial/ins_model.hpp>

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include <wayfare/filter/ekf.hpp>
#include <wayfare/nav/detail/corridor_motion.hpp>
#include <wayfare/testing/filter_laws.hpp>

namespace wayfare {
namespace {

TEST(ReducedIns, GeodeticAndPlanarPathsAgree) {
  const Geodetic origin{Angle::degrees(44.2), Angle::degrees(-76.5), 80.0};
  const LocalPlane plane{origin, Angle::degrees(37)};
  GeodeticHeading on_earth{origin, plane.azimuth_of_x};
  SE2d in_plane;
  for (int i = 0; i < 60'000; ++i) {  // ten minutes, 600 m with bends
    const double turn = 0.05 * std::sin(1e-3 * i), dt = 0.01;
    const double level =
        level_rate_rad_s(on_earth.position, 1.0 * std::sin(on_earth.azimuth.radians()));
    on_earth = advance(on_earth, turn + level, 1.0, dt);
    in_plane = advance(in_plane, turn, 1.0, dt);
  }
  const GeodeticHeading expected = plane.geodetic(in_plane);
  const Eigen::Vector3d apart = ned_from_geodetic(on_earth.position, expected.position);
  EXPECT_LT(apart.head<2>().norm(), 0.02);
  // Meridian convergence over 600 m.
  EXPECT_NEAR(wrap_to_pi((on_earth.azimuth - expected.azimuth).radians()), 0.0, 2e-4);
}

TEST(ReducedIns, CompensatesTheEarthRateAtStandstill) {
  // At standstill the gyro measures the Earth rate; the azimuth is constant.
  const Geodetic at{Angle::degrees(60), Angle::degrees(10), 0.0};
  const GeodeticHeading start{at, Angle::degrees(30)};
  const double measured = wgs84::kEarthRate_radps * std::sin(at.latitude.radians());
  EXPECT_NEAR(level_rate_rad_s(at, 0.0), measured, 1e-12);
  const auto later = advance(start, measured, 0.0, 3600.0);
  EXPECT_NEAR(later.azimuth.degrees(), 30.0, 1e-9);
  // The upward gyro is positive counter-clockwise: the azimuth decreases (Liu's signs).
  EXPECT_NEAR(advance(start, measured + 0.01, 0.0, 10.0).azimuth.radians(),
              start.azimuth.radians() - 0.1, 1e-12);
}

using namespace corridor_state;

CorridorVector some_state() {
  CorridorVector x = CorridorVector::Zero();
  x[kX] = 3.0, x[kY] = -2.0, x[kSpeed] = 0.6, x[kHeading] = 0.7;
  x[kSpeedX] = 0.6 * std::cos(0.7), x[kSpeedY] = 0.6 * std::sin(0.7);
  x[kAcceleration] = 0.02, x[kBiasWalk] = 0.003, x[kBiasConstant] = 0.02, x[kBiasDrift] = 1e-4;
  x[kScale] = 0.01;
  return x;
}

const CorridorInput kInput{
    .dt_s = 0.2, .turn_rate_rad_s = 0.4, .speed_m_s = 0.7, .speed_before_m_s = 0.6};

TEST(CorridorMotion, PhiIsTheDerivativeOfTheStep) {
  const CorridorMotion motion({.bias_tau_s = 5.0});
  const auto step = motion(some_state(), kInput);
  for (int i = 0; i < kSize; ++i) {
    const double h = 1e-6;
    CorridorVector up = some_state(), down = some_state();
    up[i] += h, down[i] -= h;
    // v_x and v_y follow from speed and heading, not from their previous values.
    const CorridorVector slope = (motion(up, kInput).state - motion(down, kInput).state) / (2 * h);
    for (int j = 0; j < kSize; ++j) EXPECT_NEAR(step.phi(j, i), slope[j], 1e-7) << j << ' ' << i;
  }
}

TEST(CorridorMotion, GaussMarkovPartsAreExactForAnyStep) {
  // One step of 2 s and forty of 50 ms give the same state and variance.
  const CorridorNoise noise{.bias_sigma_rad_s = 1e-3,
                            .bias_tau_s = 3.0,
                            .acceleration_sigma_m_s2 = 0.1,
                            .acceleration_tau_s = 1.5};
  const CorridorMotion motion(noise);
  Ekf<CorridorVector> once(some_state(), 1e-2 * CorridorMatrix::Identity()), often = once;
  CorridorInput input = kInput;
  input.dt_s = 2.0;
  once.predict(motion, input);
  input.dt_s = 0.05;
  for (int i = 0; i < 40; ++i) often.predict(motion, input);
  for (const int i : {kBiasWalk, kAcceleration}) {
    EXPECT_NEAR(once.state()[i], often.state()[i], 1e-12);
    EXPECT_NEAR(once.covariance()(i, i), often.covariance()(i, i), 1e-14);
  }
  // Without measurements the variance becomes stationary.
  input.dt_s = 100.0;
  once.predict(motion, input);
  EXPECT_NEAR(std::sqrt(once.covariance()(kBiasWalk, kBiasWalk)), 1e-3, 1e-9);
}

TEST(CorridorMotion, KeepsTheCovarianceValid) {
  const Ekf<CorridorVector> filter(some_state(), 1e-3 * CorridorMatrix::Identity());
  testing::FilterLaws<CorridorVector>{filter}.check_predict(CorridorMotion(), kInput);
  CorridorInput rest = kInput;
  rest.at_rest = true;
  testing::FilterLaws<CorridorVector>{filter}.check_predict(CorridorMotion(), rest);
  EXPECT_EQ(CorridorMotion()(some_state(), rest).state[kHeading], some_state()[kHeading]);
  EXPECT_EQ(CorridorMotion()(some_state(), rest).state[kSpeed], 0.0);
}

TEST(CorridorMotion, VelocitiesAreThoseOfSpeedAndHeading) {
  const auto x = CorridorMotion()(some_state(), kInput).state;
  EXPECT_NEAR(x[kSpeedX], x[kSpeed] * std::cos(x[kHeading]), 1e-12);
  EXPECT_NEAR(x[kSpeedY], x[kSpeed] * std::sin(x[kHeading]), 1e-12);
}

}  // namespace
}  // namespace wayfare
