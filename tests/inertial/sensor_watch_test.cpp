// Checks of inertial readings: time stamps, rest, noise, magnetic field.

#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/inertial/ahrs_parameters.hpp>
#include <wayfare/inertial/detail/ahrs_heading.hpp>
#include <wayfare/inertial/detail/ahrs_readings.hpp>
#include <wayfare/inertial/detail/rest_detector.hpp>
#include <wayfare/inertial/detail/sample_clock.hpp>

#include "core/at.hpp"

namespace wayfare {
namespace {

using Eigen::Vector3d;
using Verdict = SampleClock::Verdict;
using tests::at;

Vector3d noise(Rng& rng, double sigma) {
  const double x = rng.normal(), y = rng.normal();
  return sigma * Vector3d(x, y, rng.normal());
}

TEST(SampleClock, GivesTheStepBetweenReadingsInOrder) {
  SampleClock clock(1.0);
  EXPECT_FALSE(clock.started());
  EXPECT_EQ(clock.check(at(5.0)), Verdict::first);
  EXPECT_EQ(clock.check(at(5.25)), Verdict::next);
  EXPECT_EQ(clock.step_s(), 0.25);
  EXPECT_EQ(clock.check(at(5.25)), Verdict::late);  // duplicate
  EXPECT_EQ(clock.check(at(5.1)), Verdict::late);
  EXPECT_EQ(clock.check(at(5.5)), Verdict::next);
  EXPECT_EQ(clock.step_s(), 0.25);  // from the last reading in order
  EXPECT_EQ(clock.last(), at(5.5));
  clock.forget();
  EXPECT_FALSE(clock.started());
  EXPECT_EQ(clock.check(at(2.0)), Verdict::first);
}

TEST(SampleClock, RestartsAfterTheClockWasSetBack) {
  SampleClock clock(1.0);
  (void)clock.check(at(100.0));
  double rejected_until = 0.0;
  for (double t = 3.0; clock.check(at(t)) == Verdict::late; t += 0.1) rejected_until = t;
  EXPECT_NEAR(rejected_until, 4.0, 0.05);  // after a second of late readings only
  EXPECT_EQ(clock.check(at(4.2)), Verdict::next);
}

// Occasional late readings, however many in total, are not a clock set back.
TEST(SampleClock, OccasionalLateReadingsDoNotRestart) {
  SampleClock clock(1.0);
  for (int i = 0; i < 1000; ++i) {
    EXPECT_EQ(clock.check(at(0.01 * i)), i == 0 ? Verdict::first : Verdict::next);
    if (i > 50) {
      EXPECT_EQ(clock.check(at(0.01 * (i - 50))), Verdict::late);
    }
  }
  // Nor are shuffled times without progress.
  for (int i = 0; i < 1000; ++i)
    EXPECT_EQ(clock.check(at(5.0 + 0.01 * (i * 37 % 101))), Verdict::late) << i;
}

TEST(RestDetector, MeasuresTheTimeSinceTheLastMotion) {
  Rng rng(1);
  RestDetector<double> rest(0.05, 0.5);
  const Vector3d bias(0.01, -0.02, 0.005), up(0.3, -0.2, 9.8);
  const auto feed = [&](double seconds, double rate_sigma, double force_sigma) {
    for (int i = 0; i < static_cast<int>(seconds * 100.0); ++i) {
      rest.add_rate(bias + noise(rng, rate_sigma), 0.01);
      rest.add_force(up + noise(rng, force_sigma), 0.01);
    }
  };
  // Its averages of half a second start at zero and converge to gravity first: 9.8 m/s² decays
  // below 0.5 m/s² in about 3 time constants.
  feed(10.0, 0.004, 0.05);
  EXPECT_GT(rest.still_s(), 7.0);
  EXPECT_LT(rest.still_s(), 10.0);
  EXPECT_LT((rest.mean_rate() - bias).norm(), 0.002);
  feed(1.0, 0.2, 0.05);  // rotated
  EXPECT_LT(rest.still_s(), 0.2);
  feed(5.0, 0.004, 0.05);
  EXPECT_GT(rest.still_s(), 3.0);
  feed(1.0, 0.004, 2.0);  // vibration without rotation
  EXPECT_LT(rest.still_s(), 0.2);
  feed(5.0, 0.004, 0.05);
  rest.reset();
  EXPECT_EQ(rest.still_s(), 0.0);
}

TEST(RestDetector, NeedsBothSensors) {
  RestDetector<float> rest(0.05F, 0.5F);
  for (int i = 0; i < 1000; ++i) rest.add_rate(Eigen::Vector3f::Zero(), 0.01F);
  EXPECT_EQ(rest.still_s(), 0.0F);  // no forces yet
}

// Variance of the angle: (σ² + s²ω²)·dt, additive over steps of any length.
TEST(GyroNoise, WhiteNoiseIsAdditiveOverSteps) {
  AhrsParameters p;
  const Vector3d rate(1.0, -2.0, 2.0);
  GyroNoise<double> noise(p);
  const double want = p.rate_noise * p.rate_noise + 9.0 * p.rate_scale_noise * p.rate_scale_noise;
  EXPECT_NEAR(noise.angle_variance(rate, rate, 1.0, false, false), want, 1e-15);
  double sum = 0.0;
  for (int i = 0; i < 1000; ++i) sum += noise.angle_variance(rate, rate, 0.001, false, false);
  EXPECT_NEAR(sum, want, 1e-12);
  EXPECT_NEAR(noise.bias_variance(4.0), 4.0 * p.bias_walk * p.bias_walk, 1e-18);
}

// A saturated sensor has a constant error fraction·ω: variance (fraction·ω·t)² after t, at any
// sampling rate, restarting after recovery.
TEST(GyroNoise, SaturationGrowsWithTime) {
  AhrsParameters p;
  p.rate_noise = p.rate_scale_noise = 0.0;
  p.saturated_part = 0.3;
  const Vector3d rate(0.0, 0.0, 10.0);
  for (const int steps : {1, 10, 1000}) {
    GyroNoise<double> noise(p);
    for (int again = 0; again < 2; ++again) {
      double sum = 0.0;
      for (int i = 0; i < steps; ++i)
        sum += noise.angle_variance(rate, rate, 0.5 / steps, false, true);
      EXPECT_NEAR(sum, std::pow(0.3 * 10.0 * 0.5, 2), 1e-10) << steps;
      EXPECT_EQ(noise.angle_variance(rate, rate, 0.1, false, false), 0.0);
    }
  }
}

TEST(GyroNoise, CoarseStepAddsHalfTheChangeOfRate) {
  AhrsParameters p;
  p.rate_noise = p.rate_scale_noise = 0.0;
  GyroNoise<double> noise(p);
  const Vector3d rate(1.0, 0.0, 0.0), last(0.0, 0.0, 2.0);
  EXPECT_NEAR(noise.angle_variance(rate, last, 0.2, true, false), 0.25 * 5.0 * 0.04, 1e-15);
  EXPECT_EQ(noise.angle_variance(rate, last, 0.2, false, false), 0.0);
}

using Gate = MagneticGate<double>;

/// `dip_deg` below the horizon, towards `heading_deg` east of north.
Vector3d field(double norm_uT, double dip_deg, double heading_deg = 0.0) {
  const double dip = dip_deg * std::numbers::pi / 180.0,
               heading = heading_deg * std::numbers::pi / 180.0;
  return norm_uT * Vector3d(std::cos(dip) * std::sin(heading), std::cos(dip) * std::cos(heading),
                            -std::sin(dip));
}

/// The last verdict of `seconds` of readings at 50 Hz.
Gate::Field feed(Gate& gate, const Vector3d& f, double seconds, bool turning = false) {
  Gate::Field last{};
  for (int i = 0; i < static_cast<int>(std::lround(seconds * 50.0)); ++i)
    last = gate.update(f, 0.02, turning);
  return last;
}

TEST(MagneticGate, LearnsTheFieldAndDetectsOthersByStrengthAndDip) {
  AhrsParameters p;
  p.field_norm_gate = 0.1;
  p.field_dip_gate = Angle::degrees(10.0);
  p.field_settle_s = 1.0;
  const struct {
    double norm, dip, heading;
    Gate::Field want;
  } cases[] = {{50, 65, 0, Gate::Field::earth},     {50, 65, 140, Gate::Field::earth},
               {54, 65, 0, Gate::Field::earth},     {46, 65, 0, Gate::Field::earth},
               {57, 65, 0, Gate::Field::disturbed}, {43, 65, 0, Gate::Field::disturbed},
               {50, 73, 0, Gate::Field::earth},     {50, 77, 0, Gate::Field::disturbed},
               {50, 53, 0, Gate::Field::disturbed}, {50, -65, 0, Gate::Field::disturbed},
               {-50, 65, 0, Gate::Field::disturbed}};
  for (const auto& c : cases) {
    Gate gate(p);
    EXPECT_EQ(feed(gate, field(50, 65), 0.9), Gate::Field::settling);
    EXPECT_EQ(feed(gate, field(50, 65), 0.3), Gate::Field::earth);
    EXPECT_NEAR(gate.earth().norm(), 50.0, 1e-9);
    gate.forget_average();  // as after a heading reset
    EXPECT_EQ(gate.update(field(c.norm, c.dip, c.heading), 0.02, false), c.want)
        << c.norm << ' ' << c.dip << ' ' << c.heading;
  }
}

TEST(MagneticGate, SettlesAgainAfterADisturbance) {
  AhrsParameters p;
  Gate gate(p);
  feed(gate, field(50, 65), 30.0);
  EXPECT_EQ(feed(gate, field(80, 20), 2.0), Gate::Field::disturbed);
  EXPECT_EQ(feed(gate, field(50, 65), 0.5 * p.field_settle_s + 0.3), Gate::Field::settling);
  EXPECT_EQ(feed(gate, field(50, 65), p.field_settle_s), Gate::Field::earth);
  EXPECT_NEAR(gate.earth().norm(), 50.0, 0.1);
}

TEST(MagneticGate, RelearnsOnlyWhileTurning) {
  AhrsParameters p;
  p.field_relearn_s = 20.0;
  Gate still(p), turning(p);
  feed(still, field(50, 65), 60.0);
  feed(turning, field(50, 65), 60.0);
  EXPECT_EQ(feed(still, field(40, 45), 100.0, false), Gate::Field::disturbed);
  EXPECT_EQ(still.relearned(), 0);
  EXPECT_EQ(feed(turning, field(40, 45), 18.0, true), Gate::Field::disturbed);
  EXPECT_EQ(turning.relearned(), 0);
  EXPECT_EQ(feed(turning, field(40, 45), 6.0, true), Gate::Field::earth);
  EXPECT_EQ(turning.relearned(), 1);
  EXPECT_NEAR(turning.earth().norm(), 40.0, 0.5);
}

TEST(MagneticGate, GivenFieldIsFixed) {
  AhrsParameters p;
  p.field_norm_uT = 48.0;
  p.field_dip = Angle::degrees(60.0);
  Gate gate(p);
  EXPECT_NEAR(gate.earth().x(), 24.0, 1e-12);
  EXPECT_EQ(feed(gate, field(51, 63), 30.0), Gate::Field::earth);
  EXPECT_NEAR(gate.earth().y(), 48.0 * std::sqrt(0.75), 1e-12);
  Gate other(p);
  EXPECT_EQ(feed(other, field(70, 60), 5.0), Gate::Field::disturbed);
}

}  // namespace
}  // namespace wayfare
