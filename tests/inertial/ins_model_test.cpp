#include <wayfare/inertial/ins_model.hpp>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/filter/ekf.hpp>
#include <wayfare/inertial/ins_state.hpp>
#include <wayfare/testing/filter_laws.hpp>
#include <wayfare/testing/lie_group_laws.hpp>

#include "filter/numeric_jacobian.hpp"

namespace wayfare {
namespace {

using Eigen::Vector3d;

template <int Offsets>
InsState<double, Offsets> some_state() {
  InsState<double, Offsets> x;
  x.position_m = Vector3d(1200.0, -800.0, 15.0);
  x.velocity_mps = Vector3d(12.0, -7.0, 0.4);
  x.q_nu = SO3d::exp(Vector3d(0.05, -0.1, 2.2));
  x.gyro_bias_radps = Vector3d(0.002, -0.001, 0.003);
  x.accel_bias_mps2 = Vector3d(0.05, -0.02, 0.1);
  x.gyro_scale = Vector3d(0.002, -0.004, 0.001);
  x.accel_scale = Vector3d(-0.003, 0.002, 0.004);
  x.clock[0] = 140.0;
  x.clock[1] = 3.0;
  return x;
}

const ImuInterval kTurning{
    {0.1, -0.05, 0.4}, {0.12, -0.02, 0.45}, {1.0, 2.0, -9.6}, {1.3, 1.8, -9.9}, 0.01};

LocalTangentPlane plane() {
  return LocalTangentPlane({Angle::degrees(48.7), Angle::degrees(9.1), 300.0});
}

template <int N>
Eigen::Matrix<double, N, N> some_covariance(std::uint64_t seed) {
  Rng rng(seed);
  Eigen::Matrix<double, N, N> a;
  for (auto& x : a.reshaped()) x = rng.normal();
  Eigen::Matrix<double, N, 1> s = Eigen::Matrix<double, N, 1>::Constant(2.0);
  s.template segment<3>(3).setConstant(0.1);
  s.template segment<3>(6).setConstant(0.01);
  s.template segment<3>(9).setConstant(1e-3);
  s.template segment<3>(12).setConstant(0.03);
  s.template segment<6>(15).setConstant(2e-3);
  const Eigen::Matrix<double, N, N> p =
      s.asDiagonal() *
      (a * a.transpose() / N + 0.1 * Eigen::Matrix<double, N, N>::Identity()).eval() *
      s.asDiagonal();
  return 0.5 * (p + p.transpose());
}

TEST(InsState, IsAManifold) { testing::ManifoldLaws<InsState<double, 0>>{}.check(); }
TEST(InsState, IsAManifoldWithMoreClocks) { testing::ManifoldLaws<InsState<double, 3>>{}.check(); }

// Φ neglects terms below 1e-6 of an error per second: gravity gradient (3e-6/s²), derivative of the
// transport rate by velocity (2e-7/m), second-order terms of the step.
TEST(InsModel, PhiIsTheDerivativeOfTheStep) {
  const LocalTangentPlane c = plane();
  const InsModel<double, 1> model(c, InsNoise<double>(ImuNoise{}, {}));
  const auto x = some_state<1>();
  TangentOf<InsState<double, 1>> step;
  step.setConstant(1e-4);
  step.head<3>().setConstant(1.0);
  const auto numeric =
      tests::numeric_jacobian([&](const auto& s) { return model(s, kTurning).state; }, x, step);
  const auto phi = model(x, kTurning).phi();
  for (int i = 0; i < phi.rows(); ++i) {
    for (int j = 0; j < phi.cols(); ++j) {
      // Rotation within the step: T²/2 of forces and rates, below 6e-4 m/s and 4e-5 rad.
      const bool unit = j >= ins_state::kAttitude && j < ins_state::kClock;
      const double tolerance = !unit ? 2e-6 : i < ins_state::kAttitude ? 6e-4 : 4e-5;
      EXPECT_NEAR(phi(i, j), numeric(i, j), tolerance) << i << ", " << j;
    }
  }
}

// A rate explained by noise alone must not update the scale, whose estimate it would bias.
TEST(InsModel, NoiseIsNoEvidenceOfScale) {
  const LocalTangentPlane c = plane();
  const InsModel<double, 0> model(c, InsNoise<double>(ImuNoise{}, {}));
  // √(white²/dt + bias²) is 0.0018 … 0.0020 rad/s and 0.042 m/s².
  const Vector3d rate(0.005, -0.007, 0.3), force(0.1, -0.15, -9.8);
  const auto step = model(InsState<double, 0>{}, ImuInterval{rate, rate, force, force, 0.01});
  const auto& f = detail::rows_at<0>(step.rows).phi;
  EXPECT_EQ(f.attitude_gyro_scale.x(), 0.0);
  EXPECT_NEAR(f.attitude_gyro_scale.y(), 0.01 * 0.007, 1e-9);
  EXPECT_NEAR(f.attitude_gyro_scale.z(), -0.01 * 0.3, 1e-9);
  EXPECT_EQ(f.scale_force.x(), 0.0);
  EXPECT_NEAR(f.scale_force.y(), -0.15, 1e-12);
}

TEST(InsModel, SparsePropagationIsTheDenseProduct) {
  const LocalTangentPlane c = plane();
  {
    const InsModel<double, 0> model(c, InsNoise<double>(ImuNoise{}, {}));
    const Ekf<InsState<double, 0>> filter(some_state<0>(), some_covariance<23>(1));
    testing::FilterLaws<InsState<double, 0>>{filter, 1e-12}.check_predict(model, kTurning);
  }
  const InsModel<double, 3> model(c, InsNoise<double>(ImuNoise{}, {}));
  const Ekf<InsState<double, 3>> filter(some_state<3>(), some_covariance<26>(2));
  testing::FilterLaws<InsState<double, 3>>{filter, 1e-12}.check_predict(model, kTurning);
}

template <class P>
class InsPacks : public ::testing::Test {};
using Packs = ::testing::Types<Pack<double, 2>, Pack<double, 4>, Pack<double, 8>, Pack<float, 4>,
                               Pack<float, 8>, Pack<float, 16>>;
TYPED_TEST_SUITE(InsPacks, Packs);

// Every lane has its own noise and initial state, and must match a separate filter.
TYPED_TEST(InsPacks, LanesAreIndependentFilters) {
  using P = TypeParam;
  using T = typename P::Lane;
  const LocalTangentPlane c = plane();
  const auto x = some_state<0>();
  const auto p = some_covariance<23>(3);
  InsNoise<P> noise(ImuNoise{}, {});
  InsState<P, 0> start = x.template cast<P>();
  for (int i = 0; i < P::kLanes; ++i) {
    noise.gyro_white[1].set(i, static_cast<T>(1e-4 * (1 + i)));
    noise.tau_s[4].set(i, static_cast<T>(50.0 * (1 + i)));
    start.velocity_mps[0].set(i, static_cast<T>(i));
  }
  Ekf<InsState<P, 0>> many(start, p.template cast<P>());
  for (int k = 0; k < 20; ++k) many.predict(InsModel<P, 0>(c, noise), kTurning);
  for (int i = 0; i < P::kLanes; ++i) {
    InsNoise<double> own(ImuNoise{}, {});
    own.gyro_white[1] = 1e-4 * (1 + i);
    own.tau_s[4] = 50.0 * (1 + i);
    auto y = x;
    y.velocity_mps[0] = i;
    Ekf<InsState<double, 0>> one(y, p);
    for (int k = 0; k < 20; ++k) one.predict(InsModel<double, 0>(c, own), kTurning);
    const double eps = std::numeric_limits<T>::epsilon();
    const auto near = [&](const auto& lanes, double value, double scale) {
      EXPECT_NEAR(lanes[i], value, 100.0 * eps * scale);
    };
    for (int a = 0; a < 3; ++a) {
      near(many.state().position_m[a], one.state().position_m[a], 1200.0);
      near(many.state().velocity_mps[a], one.state().velocity_mps[a], 20.0);
      near(many.state().q_nu.quaternion().vec()[a], one.state().q_nu.quaternion().vec()[a], 1.0);
    }
    for (int a = 0; a < 23; ++a) {
      for (int b = 0; b < 23; ++b) {
        near(many.covariance()(a, b), one.covariance()(a, b),
             std::sqrt(one.covariance()(a, a) * one.covariance()(b, b)));
      }
    }
  }
}

}  // namespace
}  // namespace wayfare
