// Unit tests of the AHRS components; ahrs/ tests the whole.

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/inertial/attitude.hpp>
#include <wayfare/inertial/detail/ahrs_heading.hpp>
#include <wayfare/inertial/detail/ahrs_level.hpp>
#include <wayfare/inertial/detail/ahrs_readings.hpp>

#include "core/at.hpp"

namespace wayfare {
namespace {

using Eigen::Vector3d;
using Filter = AhrsFilter<double>;
using tests::at;

constexpr double kGravity = 9.80665;
constexpr double kDegree = std::numbers::pi / 180.0;

TEST(Attitude, EastNorthUpToNorthEastDown) {
  const SO3d ned = rotation_from_enu<frame::Ned, double>();
  EXPECT_LT((ned * Vector3d(1, 2, 3) - Vector3d(2, 1, -3)).norm(), 1e-15);
  EXPECT_LT((ned * ned).log().norm(), 1e-7);  // an involution
  const SO3d enu = rotation_from_enu<frame::Enu, double>();
  EXPECT_EQ((enu * Vector3d(1, 2, 3)), Vector3d(1, 2, 3));
}

// x to the east is 90° in both frames.
TEST(Attitude, CompassIsClockwiseFromNorth) {
  for (double degrees = -170.0; degrees <= 170.0; degrees += 20.0) {
    for (const double pitch : {0.0, 0.6}) {
      const SO3d q_ned = SO3d::exp({0.0, 0.0, degrees * kDegree}) * SO3d::exp({0.0, pitch, 0.0});
      EXPECT_NEAR(compass_of_x<frame::Ned>(q_ned).degrees(), degrees, 1e-9);
      const SO3d q_enu = rotation_from_enu<frame::Ned, double>().inverse() * q_ned;
      EXPECT_NEAR(compass_of_x<frame::Enu>(q_enu).degrees(), degrees, 1e-9);
    }
  }
}

TEST(SensorReport, CountsEveryOutcomeOnce) {
  SensorReport report;
  const UpdateStatus all[] = {UpdateStatus::used, UpdateStatus::waiting,   UpdateStatus::missing,
                              UpdateStatus::late, UpdateStatus::saturated, UpdateStatus::disturbed};
  std::size_t times = 0;
  for (const UpdateStatus status : all) {
    ++times;
    for (std::size_t i = 0; i < times; ++i) EXPECT_EQ(report.note(status), status);
  }
  EXPECT_EQ(report.used, 1U);
  EXPECT_EQ(report.waiting, 2U);
  EXPECT_EQ(report.missing, 3U);
  EXPECT_EQ(report.late, 4U);
  EXPECT_EQ(report.saturated, 5U);
  EXPECT_EQ(report.disturbed, 6U);
}

Filter rotated_filter() {
  Filter f;
  f.set_attitude(SO3d::exp({0.4, -0.9, 1.1}));
  for (int i = 0; i < Filter::kSize; ++i)
    for (int j = 0; j <= i; ++j) f.covariance()(i, j) = i == j ? 0.5 : 0.01;
  return f;
}

TEST(Alignment, LevellingIsTheSmallestRotation) {
  Rng rng(1);
  for (int round = 0; round < 50; ++round) {
    Filter f = rotated_filter();
    const SO3d before = f.q_enu_body();
    const double x = rng.normal(), y = rng.normal();
    const Vector3d force = kGravity * Vector3d(x, y, rng.normal()).normalized();
    f.level(force, 0.02);
    EXPECT_LT((f.rotation() * force - Vector3d(0, 0, kGravity)).norm(), 1e-9);
    const Vector3d turn = (f.q_enu_body() * before.inverse()).log();
    EXPECT_NEAR(turn.z(), 0.0, 1e-9);  // no rotation about the vertical
    const double angle = std::acos((before * force).z() / kGravity);
    EXPECT_NEAR(turn.norm(), angle, 1e-7);
    const auto p = f.covariance().dense();
    EXPECT_NEAR(p(0, 0), 4e-4, 1e-15);
    EXPECT_NEAR(p(2, 2), 0.5 + 0.25 * angle * angle, 1e-7);
    EXPECT_EQ(p(0, 1), 0.0);
    EXPECT_EQ(p(0, 3), 0.0);
    EXPECT_EQ(p(3, 4), 0.01);  // the bias covariance is kept
  }
}

TEST(Alignment, TurningTheHeadingRotatesTheVelocity) {
  Filter f = rotated_filter();
  f.set_velocity({1.0, 2.0});
  const Vector3d up_before = f.q_enu_body().inverse() * Vector3d::UnitZ();
  const double heading = compass_of_x<frame::Enu>(f.q_enu_body()).radians();
  f.turn_heading(0.5 * std::numbers::pi, 0.1);
  EXPECT_LT((f.velocity() - Eigen::Vector2d(-2.0, 1.0)).norm(), 1e-15);
  EXPECT_LT((f.q_enu_body().inverse() * Vector3d::UnitZ() - up_before).norm(), 1e-15);
  EXPECT_NEAR(std::remainder(compass_of_x<frame::Enu>(f.q_enu_body()).radians() - heading,
                             2.0 * std::numbers::pi),
              -0.5 * std::numbers::pi, 1e-12);
  EXPECT_NEAR(f.covariance()(2, 2), 0.01, 1e-15);
}

TEST(Alignment, ForgettingKeepsTheOtherStates) {
  const AhrsParameters p;
  Filter f = rotated_filter();
  f.set_bias({0.1, 0.2, 0.3});
  f.set_velocity({1.0, 2.0});
  f.forget_bias(p);
  EXPECT_EQ(f.bias(), Vector3d(0, 0, 0));
  EXPECT_DOUBLE_EQ(f.covariance()(3, 3), p.bias_sigma * p.bias_sigma);
  EXPECT_EQ(f.covariance()(3, 6), 0.0);
  EXPECT_EQ(f.covariance()(0, 6), 0.01);
  EXPECT_EQ(f.velocity(), Eigen::Vector2d(1.0, 2.0));
  f.forget_velocity(4.0);
  EXPECT_EQ(f.velocity(), Eigen::Vector2d(0, 0));
  EXPECT_EQ(f.covariance()(7, 7), 4.0);
  EXPECT_EQ(f.covariance()(0, 6), 0.0);
  EXPECT_EQ(f.covariance()(0, 1), 0.01);
}

TEST(AhrsLevel, StartsFromReadingsCloseToGravity) {
  AhrsLevel<double> level{AhrsParameters{}};
  Filter f;
  EXPECT_FALSE(level.start(f, Vector3d(0, 0, 0.4 * kGravity), Vector3d::Zero()));
  EXPECT_FALSE(level.start(f, Vector3d(0, 0, 1.6 * kGravity), Vector3d::Zero()));
  const Vector3d tilted = SO3d::exp({0.3, 0.0, 0.0}).inverse() * Vector3d(0, 0, kGravity);
  ASSERT_TRUE(level.start(f, tilted, Vector3d::Zero()));
  EXPECT_LT((f.rotation() * tilted - Vector3d(0, 0, kGravity)).norm(), 1e-9);
  const double at_rest = f.covariance()(0, 0);
  EXPECT_NEAR(std::sqrt(at_rest), 2.0 * kDegree, 0.1 * kDegree);
  ASSERT_TRUE(level.start(f, 1.2 * tilted, Vector3d(1.0, 0.0, 0.0)));
  EXPECT_NEAR(f.covariance()(0, 0), 0.0012 + 9.0 * 0.04 + 0.16, 1e-9);
}

// At rest the gyro reads its bias and the tilt converges to the measured gravity.
TEST(AhrsLevel, EstimatesTheBiasAtRest) {
  AhrsParameters p;
  AhrsLevel<double> level(p);
  Filter f;
  f.forget_bias(p);
  const Vector3d bias(0.010, -0.006, 0.004), up(0.0, 0.0, kGravity);
  ASSERT_TRUE(level.start(f, up, bias));
  f.turn_heading(0.0, 0.0);
  for (int i = 0; i < 100 * 30; ++i) {
    level.add_rate(bias, 0.01);
    f.turn(bias - f.bias(), 0.01, p.rate_noise * p.rate_noise * 0.01,
           p.bias_walk * p.bias_walk * 0.01);
    EXPECT_FALSE(level.add_force(f, up, f.rotation() * up, 0.01, 1e-6));
  }
  EXPECT_TRUE(level.at_rest());
  EXPECT_LT((f.bias() - bias).norm(), 3e-4);
  EXPECT_LT((f.rotation() * up - up).norm() / kGravity, 0.5 * kDegree);
  level.forget_rest();
  EXPECT_FALSE(level.at_rest());
}

TEST(AhrsLevel, RecoversFromUpsideDown) {
  AhrsParameters p;
  AhrsLevel<double> level(p);
  Filter f;
  const Vector3d up(0.0, 0.0, kGravity);
  ASSERT_TRUE(level.start(f, up, Vector3d::Zero()));
  f.set_attitude(SO3d::exp({std::numbers::pi - 0.01, 0.0, 0.0}));
  bool found = false;
  for (int i = 0; i < 300 && !found; ++i) {
    level.add_rate(Vector3d::Zero(), 0.01);
    found = level.add_force(f, up, f.rotation() * up, 0.01, 1e-6);
  }
  EXPECT_TRUE(found);
  EXPECT_GT((f.rotation() * up).z(), 0.99 * kGravity);
}

/// Level to 1°, its heading unknown.
Filter levelled() {
  Filter f;
  f.covariance().decouple(0, kDegree * kDegree);
  f.covariance().decouple(1, kDegree * kDegree);
  f.covariance().decouple(2, Filter::kUnknown);
  return f;
}

/// A field of 48 µT and 60° dip measured at a compass heading, in a filter whose x axis points
/// east.
Vector3d field_at(double compass_of_x_deg) {
  const double turned = (compass_of_x_deg - 90.0) * kDegree;  // clockwise
  return SO3d::exp({0.0, 0.0, turned}) * Vector3d(0.0, 24.0, -24.0 * std::sqrt(3.0));
}

TEST(AhrsHeading, InitialisesFromTheFirstField) {
  AhrsParameters p;
  p.declination = Angle::degrees(4.0);
  for (const double compass : {-150.0, 20.0, 90.0}) {
    AhrsHeading<double> heading(p);
    Filter f = levelled();
    EXPECT_FALSE(heading.known());
    const auto first = heading.update(f, field_at(compass), Vector3d::Zero(), 0.02);
    EXPECT_EQ(first.status, UpdateStatus::used);
    EXPECT_TRUE(heading.known());
    // Magnetic north is 4° east of true north.
    EXPECT_NEAR(
        std::remainder(compass_of_x<frame::Enu>(f.q_enu_body()).degrees() - compass - 4.0, 360.0),
        0.0, 1e-9);
    // 0.17 rad of the reading, and a tilt error of 1° with a dip of 60°: 1°·tan 60°.
    EXPECT_NEAR(f.covariance()(2, 2), 0.17 * 0.17 + 3.0 * kDegree * kDegree, 1e-9);
  }
}

TEST(AhrsHeading, WaitsForTheTiltAndRejectsPolesAndDisturbances) {
  AhrsParameters p;
  p.field_norm_uT = 48.0;
  p.field_dip = Angle::degrees(60.0);
  AhrsHeading<double> heading(p);
  Filter tilted = levelled();
  tilted.covariance().decouple(0, 1.0);
  EXPECT_EQ(heading.update(tilted, field_at(0), Vector3d::Zero(), 0.02).status,
            UpdateStatus::waiting);
  Filter f = levelled();
  EXPECT_EQ(heading.update(f, Vector3d(0.0, 1.0, -48.0), Vector3d::Zero(), 0.02).status,
            UpdateStatus::disturbed);  // 89° steep
  EXPECT_FALSE(heading.known());
  heading.set(f, Angle::degrees(30.0), Angle::degrees(2.0));
  EXPECT_TRUE(heading.known());
  EXPECT_NEAR(compass_of_x<frame::Enu>(f.q_enu_body()).degrees(), 30.0, 1e-9);
  EXPECT_EQ(heading.update(f, 2.0 * field_at(90), Vector3d::Zero(), 0.02).status,
            UpdateStatus::disturbed);
  EXPECT_NEAR(compass_of_x<frame::Enu>(f.q_enu_body()).degrees(), 30.0, 1e-9);
  heading.forget();
  EXPECT_FALSE(heading.known());
}

// Readings are checked before they change anything.
TEST(AhrsReadings, ChecksTimeRangeAndFiniteness) {
  AhrsParameters p;
  AhrsReadings<double> ahrs(p);
  const Vector3d up(0.0, 0.0, kGravity), nothing = Vector3d::Zero();
  EXPECT_EQ(ahrs.add_force(at(0.0), up), UpdateStatus::waiting);  // no gyro yet
  EXPECT_EQ(ahrs.add_field(at(0.0), {0, 20, -40}), UpdateStatus::waiting);
  EXPECT_EQ(ahrs.add_rate(at(0.0), nothing), UpdateStatus::used);
  EXPECT_EQ(ahrs.add_rate(at(0.01), nothing), UpdateStatus::used);
  EXPECT_EQ(ahrs.add_rate(at(0.01), nothing), UpdateStatus::late);
  EXPECT_EQ(ahrs.add_rate(at(0.02), {p.rate_range, 0.0, 0.0}), UpdateStatus::saturated);
  EXPECT_EQ(ahrs.add_rate(at(0.03), {5.0 * p.rate_range, 0.0, 0.0}), UpdateStatus::saturated);
  EXPECT_EQ(ahrs.add_rate(at(0.03), {0.0, std::nan(""), 0.0}), UpdateStatus::missing);
  EXPECT_EQ(ahrs.add_rate(at(0.03), nothing),
            UpdateStatus::used);  // the rejected one did not advance time
  EXPECT_FALSE(ahrs.ready());
  EXPECT_EQ(ahrs.add_force(at(0.03), up), UpdateStatus::used);
  EXPECT_TRUE(ahrs.ready());
  EXPECT_EQ(ahrs.add_force(at(9.0), up),
            UpdateStatus::waiting);  // the gyro stopped long before
  const AhrsReport& report = ahrs.report();
  EXPECT_EQ(report.gyro.used, 3U);
  EXPECT_EQ(report.gyro.late, 1U);
  EXPECT_EQ(report.gyro.saturated, 2U);
  EXPECT_EQ(report.gyro.missing, 1U);
  EXPECT_EQ(report.accelerometer.waiting, 2U);
  EXPECT_EQ(ahrs.add_rate(at(9.0), nothing), UpdateStatus::used);  // after a gap: restarts
  EXPECT_FALSE(ahrs.ready());
  EXPECT_EQ(report.restarts, 1U);
}

TEST(AhrsReadings, IgnoresFieldsWithoutMagnetometer) {
  AhrsParameters p;
  p.use_magnetometer = false;
  AhrsReadings<double> ahrs(p);
  EXPECT_EQ(ahrs.add_field(at(0.0), {0, 20, -40}), UpdateStatus::missing);
}

}  // namespace
}  // namespace wayfare
