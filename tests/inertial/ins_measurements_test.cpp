#include <gtest/gtest.h>

#include <wayfare/filter/sequential_update.hpp>
#include <wayfare/gnss/range_model.hpp>
#include <wayfare/inertial/imu_noise.hpp>
#include <wayfare/inertial/ins_measurements.hpp>
#include <wayfare/nav/ins_filter.hpp>
#include <wayfare/testing/filter_laws.hpp>

#include "filter/numeric_jacobian.hpp"

namespace wayfare {
namespace {

using Eigen::Vector3d;
using Ins = InsState<double, 2>;

const Geodetic kAnchor{Angle::degrees(48.7), Angle::degrees(9.1), 300.0};
const Vector3d kLever(0.8, -0.4, -1.3), kGyro(0.1, -0.2, 0.5);

Ins some_state() {
  Ins x;
  x.position_m = Vector3d(1200.0, -2800.0, 15.0);
  x.velocity_mps = Vector3d(12.0, -7.0, 0.4);
  x.q_nu = SO3d::exp(Vector3d(0.05, -0.1, 2.2));
  x.gyro_bias_radps = Vector3d(0.002, -0.001, 0.003);
  x.clock << 140.0, 3.0, -12.0, 5.0;
  return x;
}

CorrectedRange satellite() {
  CorrectedRange s;
  s.position_ecef_m =
      ecef_from_geodetic(kAnchor) + rotation_ecef_ned(kAnchor) * Vector3d(1.1e7, -0.9e7, -1.6e7);
  s.velocity_ecef_mps = Vector3d(-900.0, 2500.0, 1700.0);
  s.range_m = 2.3e7;
  s.range_rate_mps = 150.0;
  return s;
}

/// h of the model against central differences of its innovation (z − h(x): opposite sign).
template <class Model>
void expect_derivative(const Model& model, double tolerance) {
  const Ins x = some_state();
  TangentOf<Ins> step = TangentOf<Ins>::Constant(1e-4);
  step.head<3>().setConstant(10.0);
  const auto numeric =
      tests::numeric_gradient([&](const Ins& s) { return -model(s).innovation; }, x, step);
  const auto h = testing::FilterLaws<Ins>::dense(model(x).row);
  for (int i = 0; i < h.size(); ++i) {
    // The models neglect the gyro scale in the lever arm's velocity.
    if (i >= ins_state::kGyroScale && i < ins_state::kAccelScale) continue;
    EXPECT_NEAR(h[i], numeric[i], tolerance) << "entry " << i;
  }
}

TEST(RangeModel, RowIsTheDerivative) {
  const LocalTangentPlane plane(kAnchor);
  const SatelliteView view(satellite(), plane);
  // Rounding of 2e7 m is 4e-9 m; over 2e-4 rad that is 2e-5.
  expect_derivative(RangeModel<double, 2>{plane, view, 1000.0, 4.0, kLever, -1}, 5e-5);
  expect_derivative(RangeModel<double, 2>{plane, view, 1000.0, 4.0, kLever, 1}, 5e-5);
}

TEST(RangeRateModel, RowIsTheDerivative) {
  const LocalTangentPlane plane(kAnchor);
  // The model neglects the rotation of the local level with position.
  expect_derivative(RangeRateModel<double, 2>{plane, SatelliteView(satellite(), plane), 150.0, 0.01,
                                              kLever, kGyro},
                    5e-6);
}

// Range and range rate of a state computed in ECEF.
TEST(RangeModel, InnovationMatchesTheGeometry) {
  const LocalTangentPlane plane(kAnchor);
  const Ins x = some_state();
  const CorrectedRange s = satellite();
  const Geodetic g = plane.geodetic(x.position_m);
  const Eigen::Matrix3d r = rotation_ecef_ned(g);
  const Vector3d rate = kGyro - x.gyro_bias_radps;
  const Vector3d p = ecef_from_geodetic(g) + r * Vector3d(x.q_nu * kLever);
  const Vector3d v = r * (x.velocity_mps + x.q_nu * Vector3d(rate.cross(kLever)));
  const Vector3d u = (s.position_ecef_m - p).normalized();

  InsFilter<double, 2> filter(kAnchor, 1e5, x, InsFilter<double, 2>::Square::Identity(),
                              InsNoise<double>(ImuNoise{}, {}), kLever);
  const auto range = filter.range_model(s, 2.0, 0)(x);
  EXPECT_NEAR(range.innovation, s.range_m - (s.position_ecef_m - p).norm() - 1e5 - 140.0 + 12.0,
              1e-7);
  EXPECT_EQ(range.variance, 4.0);
  const RangeRateModel<double, 2> rates{
      plane, SatelliteView(s, plane), s.range_rate_mps, 0.01, kLever, kGyro};
  EXPECT_NEAR(rates(x).innovation, s.range_rate_mps - u.dot(s.velocity_ecef_mps - v) - 3.0, 1e-9);
}

// Ranges of 23 000 km in single precision, to millimetres.
TEST(RangeModel, SinglePrecisionKeepsMillimetres) {
  const LocalTangentPlane plane(kAnchor);
  const SatelliteView view(satellite(), plane);
  const Ins x = some_state();
  const RangeModel<double, 2> wide{plane, view, 1000.0, 4.0, kLever, 0};
  const RangeModel<float, 2> narrow{plane, view, 1000.0, 4.0F, kLever.cast<float>(), 0};
  EXPECT_NEAR(narrow(x.cast<float>()).innovation, wide(x).innovation, 2e-3);
}

TEST(Constraints, RowsAreDerivatives) {
  const LocalTangentPlane plane(kAnchor);
  expect_derivative(BodyVelocityModel<double, 2>{Vector3d(0.0, 1.0, 0.0), kLever, kGyro, 0.0, 0.01},
                    1e-7);
  expect_derivative(VelocityModel<double, 2>{1, 0.0, 0.01}, 1e-9);
  expect_derivative(ZeroTurnRateModel<double, 2>{2, 0.001, 1e-6}, 1e-9);
  expect_derivative(AntennaPositionModel<double, 2>{plane, Vector3d(1190.0, -2795.0, 14.0),
                                                    Vector3d(0.6, 0.0, 0.8), kLever, 1.0},
                    3e-4);  // scales of the plane change with position
}

TEST(Constraints, AntennaVelocityIncludesTheLeverArm) {
  const Ins x = some_state();
  const Vector3d direction(0.48, -0.64, 0.6), measured(11.0, -6.0, 0.2);
  const AntennaVelocityModel<double, 2> model{measured, direction, kLever, kGyro, 0.04};
  const Vector3d rate = kGyro - x.gyro_bias_radps;
  const Vector3d want = x.velocity_mps + x.q_nu * Vector3d(rate.cross(kLever));
  EXPECT_NEAR(model(x).innovation, direction.dot(measured - want), 1e-14);
  EXPECT_EQ(model(x).variance, 0.04);
  // The model neglects the gyro biases in the lever arm's velocity.
  const auto h = testing::FilterLaws<Ins>::dense(model(x).row);
  TangentOf<Ins> step = TangentOf<Ins>::Constant(1e-4);
  const auto numeric =
      tests::numeric_gradient([&](const Ins& s) { return -model(s).innovation; }, x, step);
  for (int i = 0; i < ins_state::kGyroBias; ++i) EXPECT_NEAR(h[i], numeric[i], 1e-8) << i;
  for (int i = ins_state::kGyroBias; i < h.size(); ++i) EXPECT_EQ(h[i], 0.0) << i;
}

// The point at the lever arm stands still while the unit rotates about it.
TEST(Constraints, BodyVelocityIsThatOfThePointAtTheLever) {
  Ins x = some_state();
  const Vector3d rate = kGyro - x.gyro_bias_radps;
  x.velocity_mps = x.q_nu * Vector3d(-rate.cross(kLever));
  for (int axis = 0; axis < 3; ++axis) {
    const BodyVelocityModel<double, 2> model{Vector3d::Unit(axis), kLever, kGyro, 0.3, 0.01};
    EXPECT_NEAR(model(x).innovation, 0.3, 1e-14);
  }
}

TEST(InsFilterOnPacks, EqualsSeparateFilters) {
  using P = Pack<double, 4>;
  const auto p = InsFilter<double, 0>::Square(0.01 * InsFilter<double, 0>::Square::Identity());
  InsState<double, 0> x;
  x.velocity_mps = Vector3d(5.0, 1.0, 0.0);
  InsFilter<double, 0> one(kAnchor, 0.0, x, p, InsNoise<double>(ImuNoise{}, {}), kLever);
  InsFilter<P, 0> many(kAnchor, 0.0, x.cast<P>(), p.cast<P>(), InsNoise<P>(ImuNoise{}, {}), kLever);
  const ImuInterval still{Vector3d::Zero(), Vector3d::Zero(), {0, 0, -9.81}, {0, 0, -9.81}, 0.01};
  CorrectedRange s = satellite();
  s.range_m = (s.position_ecef_m - ecef_from_geodetic(kAnchor)).norm() + 1.0;
  for (int k = 0; k < 5; ++k) {
    one.predict(still);
    many.predict(still);
    EXPECT_TRUE(one.update_range(s, 2.0, 5.0).accepted);
    // Lane 2 rejects: its gate is closed.
    P gate(5.0);
    gate.set(2, 1e-9);
    const auto u = many.update_range(s, P(2.0), gate);
    EXPECT_FALSE(u.accepted[2]);
    one.update_range_rate(s, 0.1, 1e9);
    many.update_range_rate(s, P(0.1), P(1e9));
  }
  // Inconsistent rates move the state far at every update, which magnifies rounding.
  for (int lane : {0, 1, 3}) {
    for (int i = 0; i < 23; ++i) {
      EXPECT_NEAR(many.covariance()(i, i)[lane], one.covariance()(i, i),
                  1e-9 * one.covariance()(i, i));
    }
    EXPECT_NEAR(many.state().position_m[0][lane], one.state().position_m[0], 1e-6);
  }
  EXPECT_GT(many.covariance()(2, 2)[2], one.covariance()(2, 2));
}

}  // namespace
}  // namespace wayfare
