// Navigation equations and measurement models at poles, with steps of no and of great length, and
// with numbers that are none.

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/filter/ekf.hpp>
#include <wayfare/inertial/ins_measurements.hpp>
#include <wayfare/inertial/ins_model.hpp>
#include <wayfare/inertial/ins_state.hpp>

#include "abuse/abuse.hpp"

namespace wayfare {
namespace {

using namespace tests;

const Geodetic kHere{Angle::degrees(48.7), Angle::degrees(9.1), 300.0};

ImuInterval interval(double rate, double force, double dt_s) {
  const Eigen::Vector3d w = Eigen::Vector3d::Constant(rate), f = Eigen::Vector3d::Constant(force);
  return {w, w, f, f, dt_s};
}

bool finite(const InsState<double>& x) {
  return x.position_m.allFinite() && x.velocity_mps.allFinite() &&
         x.q_nu.quaternion().coeffs().allFinite() && x.clock.allFinite();
}

TEST(InsModelAbuse, AStepOfNoLengthChangesNothing) {
  const InsModel<double> model(LocalTangentPlane(kHere), InsNoise<double>(ImuNoise{}, {}));
  InsState<double> x;
  x.velocity_mps = {10.0, -3.0, 1.0};
  x.gyro_bias_radps.setConstant(1e-3);
  const auto step = model(x, interval(0.3, 9.0, 0.0));
  EXPECT_EQ(step.state.minus(x).norm(), 0.0);
  Ekf<InsState<double>>::Square p = Ekf<InsState<double>>::Square::Identity();
  step.propagate(p);
  EXPECT_TRUE(p.isIdentity(1e-12));
}

TEST(InsModelAbuse, StaysFiniteForAnyFiniteReadingsAndSteps) {
  const InsModel<double> model(LocalTangentPlane(kHere), InsNoise<double>(ImuNoise{}, {}));
  for (const double rate : {0.0, kTiny, 200.0, -200.0}) {
    for (const double force : {0.0, kTiny, 5000.0, -5000.0}) {
      for (const double dt_s : {1e-9, 0.01, 10.0}) {
        const auto step = model(InsState<double>{}, interval(rate, force, dt_s));
        EXPECT_TRUE(finite(step.state)) << rate << ' ' << force << ' ' << dt_s;
        Ekf<InsState<double>>::Square p = Ekf<InsState<double>>::Square::Identity();
        step.propagate(p);
        EXPECT_TRUE(p.allFinite()) << rate << ' ' << force << ' ' << dt_s;
      }
    }
  }
}

TEST(InsStateAbuse, MeasurementsThatAreNotNumbersAreRejectedByTheFilter) {
  using State = InsState<double>;
  const LocalTangentPlane plane(kHere);
  for (const double x : kNotFinite) {
    Ekf<State> filter;
    const Eigen::Vector3d bad(x, 0.0, 0.0), one = Eigen::Vector3d::UnitX();
    EXPECT_FALSE(filter.update(VelocityModel<double>{0, x, 1.0}).accepted);
    EXPECT_FALSE(filter.update(ZeroTurnRateModel<double>{1, x, 1.0}).accepted);
    EXPECT_FALSE(
        filter.update(BodyVelocityModel<double>{one, bad.cross(one), bad, x, 1.0}).accepted);
    EXPECT_FALSE(filter.update(AntennaPositionModel<double>{plane, bad, one, one, 1.0}).accepted);
    EXPECT_FALSE(filter.update(AntennaVelocityModel<double>{bad, one, one, one, 1.0}).accepted);
    EXPECT_FALSE(filter.update(VelocityModel<double>{0, 1.0, kNan}).accepted);
    EXPECT_EQ(filter.state().minus(State{}).norm(), 0.0);
    EXPECT_TRUE(filter.covariance().isIdentity(0.0));
  }
  // A variance of zero, and one so large that it says nothing.
  Ekf<State> filter;
  EXPECT_TRUE(filter.update(VelocityModel<double>{0, 1.0, 0.0}).accepted);
  EXPECT_EQ(filter.state().velocity_mps[0], 1.0);
  EXPECT_TRUE(filter.update(VelocityModel<double>{1, 1.0, kHuge}).accepted);
  EXPECT_TRUE(filter.covariance().allFinite());
  EXPECT_GE(filter.covariance().diagonal().minCoeff(), 0.0);
}

TEST(ReducedInsAbuse, PolesAndHugeSpeedsAreFiniteNumbers) {
  for (const double latitude : {-90.0, -89.99999, 0.0, 90.0}) {
    for (const double speed : {0.0, 1e9, -1e9}) {
      for (const double dt_s : {0.0, 1e-9, 1e9}) {
        const GeodeticHeading at{{Angle::degrees(latitude), Angle::degrees(180.0), 0.0}, Angle()};
        const GeodeticHeading next = advance(at, 1.0, speed, dt_s);
        EXPECT_TRUE(std::isfinite(next.azimuth.radians()))
            << latitude << ' ' << speed << ' ' << dt_s;
        EXPECT_TRUE(std::isfinite(next.position.latitude.radians()));
        EXPECT_TRUE(std::isfinite(advance(SE2d(), 1.0, speed, dt_s).x()));
      }
    }
  }
  const GeodeticHeading far =
      LocalPlane{kHere, Angle()}.geodetic(SE2d(1e9, -1e9, Angle::radians(1e9)));
  EXPECT_TRUE(std::isfinite(far.position.height_m) && std::isfinite(far.azimuth.radians()));
}

TEST(StrapdownAbuse, IntervalsAtTheLimitsOfTimeHaveALength) {
  ImuSample first, last;
  first.time = LogTime() + Duration::min();
  last.time = LogTime() + Duration::max();
  EXPECT_GT(between(first, last).dt_s, 9e9);
  EXPECT_LT(between(last, first).dt_s, -9e9);
  EXPECT_EQ(between(last, last).dt_s, 0.0);
}

}  // namespace
}  // namespace wayfare
