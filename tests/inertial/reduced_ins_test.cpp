// Navigation with one gyro and wheels, in latitude and longitude and in a plane; error growth.

#include <wayfare/inertial/ins_model.hpp>

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include <wayfare/filter/ekf.hpp>
#include <wayfare/nav/detail/corridor_motion.hpp>
#include <wayfare/testing/state_laws.hpp>

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

using namespace corridor;

CorridorState some_state() {
  CorridorState x;
  x.get<Position>() << 3.0, -2.0;
  x.get<Speed>()[0] = 0.6;
  x.get<Velocity>() << 0.6 * std::cos(0.7), 0.6 * std::sin(0.7);
  x.get<Heading>()[0] = 0.7;
  x.get<Acceleration>()[0] = 0.02;
  x.get<BiasWalk>()[0] = 0.003;
  x.get<Bias>() << 0.02, 1e-4;
  x.get<Scale>()[0] = 0.01;
  return x;
}

const CorridorInput kInput{
    .dt_s = 0.2, .turn_rate_rad_s = 0.4, .speed_m_s = 0.7, .speed_before_m_s = 0.6};

TEST(CorridorMotion, SatisfiesTheLawsOfStates) {
  const testing::StateLaws<CorridorState> laws{some_state(), 1.0, 20, 1e-7};
  laws.check_state();
  CorridorInput rest = kInput;
  rest.at_rest = true;
  // v_x and v_y follow from speed and heading, not from their previous values.
  const CorridorMotion motion({.bias_tau_s = 5.0});
  laws.check_process(motion, kInput);
  laws.check_process(motion, rest);
}

TEST(CorridorMotion, GaussMarkovPartsAreExactForAnyStep) {
  // One step of 2 s and forty of 50 ms give the same state and variance.
  const CorridorNoise noise{.bias_sigma_rad_s = 1e-3,
                            .bias_tau_s = 3.0,
                            .acceleration_sigma_m_s2 = 0.1,
                            .acceleration_tau_s = 1.5};
  const CorridorMotion motion(noise);
  Ekf<CorridorState> once(some_state(), 1e-2 * SquareOf<CorridorState>::Identity()), often = once;
  CorridorInput input = kInput;
  input.dt_s = 2.0;
  once.predict(motion, input);
  input.dt_s = 0.05;
  for (int i = 0; i < 40; ++i) often.predict(motion, input);
  const auto apart = once.state().minus(often.state());
  for (const int i : CorridorState::indices<BiasWalk, Acceleration>()) {
    EXPECT_NEAR(apart[i], 0.0, 1e-12);
    EXPECT_NEAR(once.covariance()(i, i), often.covariance()(i, i), 1e-14);
  }
  // Without measurements the variance becomes stationary.
  input.dt_s = 100.0;
  once.predict(motion, input);
  constexpr int kWalk = CorridorState::index<BiasWalk>();
  EXPECT_NEAR(std::sqrt(once.covariance()(kWalk, kWalk)), 1e-3, 1e-9);
}

TEST(CorridorMotion, StandsAtRest) {
  CorridorInput rest = kInput;
  rest.at_rest = true;
  const CorridorState x = CorridorMotion()(some_state(), rest).state;
  EXPECT_EQ(x.get<Heading>(), some_state().get<Heading>());
  EXPECT_EQ(x.get<Position>(), some_state().get<Position>());
  EXPECT_EQ(x.get<Speed>()[0], 0.0);
}

TEST(CorridorMotion, VelocitiesAreThoseOfSpeedAndHeading) {
  const CorridorState x = CorridorMotion()(some_state(), kInput).state;
  const double speed = x.get<Speed>()[0], heading = x.get<Heading>()[0];
  EXPECT_NEAR(x.get<Velocity>().x(), speed * std::cos(heading), 1e-12);
  EXPECT_NEAR(x.get<Velocity>().y(), speed * std::sin(heading), 1e-12);
}

}  // namespace
}  // namespace wayfare
