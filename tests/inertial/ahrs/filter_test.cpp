// The filter's linear algebra against dense matrices and numeric derivatives.

#include <wayfare/inertial/detail/ahrs_filter.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include <wayfare/core/random.hpp>
#include <wayfare/inertial/detail/ahrs_level.hpp>

namespace wayfare {
namespace {

using Filter = AhrsFilter<double>;
using Vector9 = Eigen::Matrix<double, 9, 1>;
using Matrix = Eigen::Matrix<double, 9, 9>;
using Vector = Eigen::Vector3d;

/// The state with the filter's definition of its error.
struct Nominal {
  SO3d q = SO3d::exp({0.3, -1.1, 2.0});
  Vector bias{0.01, -0.02, 0.03};
  Eigen::Vector2d velocity{0.4, -0.3};
  double delay = 0.01;

  [[nodiscard]] Nominal plus(const Vector9& d) const {
    return {SO3d::exp(d.head<3>()) * q, bias + d.segment<3>(3), velocity + d.segment<2>(6),
            delay + d[8]};
  }
  [[nodiscard]] Vector9 minus(const Nominal& o) const {
    Vector9 d;
    d << (q * o.q.inverse()).log(), bias - o.bias, velocity - o.velocity, delay - o.delay;
    return d;
  }
};

Matrix random_covariance(Rng& rng) {
  Matrix a;
  for (double& x : a.reshaped()) x = rng.normal();
  return 0.01 * (a * a.transpose() + Matrix::Identity());
}

Filter filter_at(const Nominal& x, const Matrix& p) {
  Filter f;
  f.set_attitude(x.q);
  f.set_bias(x.bias);
  f.set_velocity(x.velocity);
  f.set_delay(x.delay);
  for (int i = 0; i < 9; ++i)
    for (int j = 0; j < 9; ++j) f.covariance()(i, j) = p(i, j);
  return f;
}

/// Central differences of `step` around `x`.
template <class Step>
Matrix jacobian(const Nominal& x, Step step) {
  constexpr double h = 1e-5;
  Matrix j;
  for (int i = 0; i < 9; ++i) {
    const Vector9 d = h * Vector9::Unit(i);
    j.col(i) = (step(x.plus(d)).minus(step(x)) - step(x.plus(-d)).minus(step(x))) / (2.0 * h);
  }
  return j;
}

template <class T>
class AhrsAttitude : public ::testing::Test {};
using Scalars = ::testing::Types<float, double>;
TYPED_TEST_SUITE(AhrsAttitude, Scalars);

TYPED_TEST(AhrsAttitude, SmallTurnIsTheExponential) {
  using T = TypeParam;
  const Eigen::Matrix<T, 3, 1> axis(T(2.0 / 7), T(-3.0 / 7), T(6.0 / 7));
  // The series ends at 0.2 rad.
  for (const T angle : {T(0), T(1e-20), T(1e-4), T(0.01), T(0.1), T(0.1999), T(0.2001), T(3)}) {
    AhrsFilter<T> f;
    f.rotate(axis * angle, T(1), T(0), T(0));
    const Eigen::Matrix<long double, 3, 1> turn = (axis * angle).template cast<long double>();
    const long double half = 0.5L * turn.norm();
    const long double part = half > 0.0L ? 0.5L * std::sin(half) / half : 0.5L;
    const auto q = f.q_enu_body().quaternion();
    constexpr long double kTolerance = 3.0L * std::numeric_limits<T>::epsilon();
    EXPECT_NEAR(q.w(), std::cos(half), kTolerance) << angle;
    for (int i = 0; i < 3; ++i)
      EXPECT_NEAR(q.vec()[i], part * turn[i], kTolerance * std::min(half, 1.0L)) << angle;
  }
}

TYPED_TEST(AhrsAttitude, RotatesLikeTheQuaternion) {
  using T = TypeParam;
  using Vector3 = Eigen::Matrix<T, 3, 1>;
  constexpr T kEpsilon = std::numeric_limits<T>::epsilon();
  Rng rng(5);
  const auto random = [&] { return Vector3(T(rng.normal()), T(rng.normal()), T(rng.normal())); };
  AhrsFilter<T> f;
  EXPECT_EQ(f.rotation(), (Eigen::Matrix<T, 3, 3>::Identity()));
  for (int i = 0; i < 1000; ++i) {
    const SO3<T> q = SO3<T>::exp(random());
    const Vector3 v = random();
    f.set_attitude(q);
    // The two formulas differ by twice the error of q's squared length on the diagonal.
    EXPECT_LT((f.rotation() - q.matrix()).norm(), T(16) * kEpsilon);
    const PaddedVector<T> world = f.in_world(v);
    EXPECT_LT((world.unpadded() - q * v).norm(), T(16) * kEpsilon * v.norm());
    EXPECT_EQ(world[3], T(0));
    const Vector3 u = random();
    EXPECT_EQ(PaddedVector<T>(u).cross(v), PaddedVector<T>(u.cross(v)));
  }
}

TEST(AhrsFilter, TurnPropagatesTheCovarianceByTheNumericJacobian) {
  Rng rng(1);
  const Nominal x;
  const Matrix p = random_covariance(rng);
  const Vector reading(0.5, -2.0, 1.0);
  constexpr double dt = 1e-3;
  Filter f = filter_at(x, p);
  f.turn(reading - x.bias, dt, 0.25, 0.5);
  const Matrix phi = jacobian(x, [&](Nominal n) {
    n.q = n.q * SO3d::exp((reading - n.bias) * dt);
    return n;
  });
  Matrix expected = phi * p * phi.transpose();
  expected.diagonal().head<3>().array() += 0.25;
  expected.diagonal().segment<3>(3).array() += 0.5;
  // The filter neglects second-order terms of one step's rotation (2 mrad here).
  EXPECT_LT((f.covariance().dense() - expected).norm(), 1e-5 * expected.norm());
  EXPECT_LT((f.q_enu_body().minus(x.q * SO3d::exp((reading - x.bias) * dt))).norm(), 1e-12);
}

// The error of the attitude in world axes does not change by the body's rotation: Φ of many
// readings is the sum of their steps. Without a walk of the bias within them nothing is neglected.
TEST(AhrsFilter, OnePropagationOverManyRotationsIsExact) {
  Rng rng(4);
  const Nominal x;
  const Matrix p = random_covariance(rng);
  Filter once = filter_at(x, p), each = filter_at(x, p);
  const Matrix before = once.covariance().dense();
  for (int i = 0; i < 20; ++i) {
    const Vector rate(rng.normal(), rng.normal(0.0, 3.0), rng.normal());
    once.rotate(rate, 0.01, 1e-4, 0.0);
    each.turn(rate, 0.01, 1e-4, 0.0);
  }
  EXPECT_EQ(once.covariance().dense(), before);
  once.propagate();
  const Matrix expected = each.covariance().dense();
  EXPECT_LT((once.covariance().dense() - expected).norm(), 1e-13 * expected.norm());
  EXPECT_GT((expected - p).norm(), 1e-3 * p.norm());
  EXPECT_TRUE(once.q_enu_body().quaternion().isApprox(each.q_enu_body().quaternion(), 0.0));
  const Matrix propagated = once.covariance().dense();
  once.propagate();
  EXPECT_EQ((once.covariance().dense() - propagated).norm(), 0.0) << "there is nothing more";
}

TEST(AhrsFilter, AccelerationPropagatesTheCovarianceByTheNumericJacobian) {
  Rng rng(2);
  const Nominal x;
  const Matrix p = random_covariance(rng);
  const Vector force(3.0, -5.0, 8.0);
  constexpr double dt = 0.02;
  Filter f = filter_at(x, p);
  f.accelerate(x.q * force, dt, 0.75);
  const Matrix phi = jacobian(x, [&](Nominal n) {
    n.velocity += (n.q * force).head<2>() * dt;
    return n;
  });
  Matrix expected = phi * p * phi.transpose();
  expected.diagonal().segment<2>(6).array() += 0.75;
  EXPECT_LT((f.covariance().dense() - expected).norm(), 1e-9 * expected.norm());
  EXPECT_LT((f.velocity() - x.velocity - (x.q * force).head<2>() * dt).norm(), 1e-12);
}

TEST(AhrsFilter, SequentialUpdatesEqualTheJointOne) {
  Rng rng(3);
  const Nominal x;
  const Matrix p = random_covariance(rng);
  Filter f = filter_at(x, p);
  f.observe(IndexedRow<double, 1, 2, 6>{{0.3, -0.4, 1.0}}, 0.01, 2.0);
  f.observe(IndexedRow<double, 2, 8>{{1.0, -3.0}}, -0.02, 0.5);
  f.apply();
  Eigen::Matrix<double, 2, 9> h = Eigen::Matrix<double, 2, 9>::Zero();
  h(0, 1) = 0.3, h(0, 2) = -0.4, h(0, 6) = 1.0, h(1, 2) = 1.0, h(1, 8) = -3.0;
  const Eigen::Matrix2d s =
      h * p * h.transpose() + Eigen::Vector2d(2.0, 0.5).asDiagonal().toDenseMatrix();
  const Eigen::Matrix<double, 9, 2> k = p * h.transpose() * s.inverse();
  const Vector9 d = k * Eigen::Vector2d(0.01, -0.02);
  const Matrix expected = p - k * h * p;
  EXPECT_LT((f.covariance().dense() - expected).norm(), 1e-9);
  const Nominal after{f.q_enu_body(), f.bias(), f.velocity(), f.delay()};
  EXPECT_LT((after.minus(x) - d).norm(), 1e-9);
}

TEST(AhrsFilter, GaussMarkovInnovationsAreWhiteAtAnyRate) {
  // A process of the model with known acceleration: the innovations are white with the model's
  // variance.
  AhrsParameters parameters;
  parameters.velocity_time_s = 0.2;
  parameters.velocity_density = 0.5;
  const double sigma2 = 0.25 / 0.4;
  for (const double dt : {0.001, 0.01, 0.3}) {
    HorizontalVelocityModel<double> model(parameters);
    model.set_step(dt);
    EXPECT_NEAR(model.variance(), sigma2, 1e-12);
    Rng rng(4);
    const double phi = std::exp(-dt / 0.2);
    double v = rng.normal(0.0, std::sqrt(sigma2)), last = 0.0, squares = 0.0, products = 0.0;
    constexpr int kSteps = 20000;
    for (int i = 0; i < kSteps; ++i) {
      const double next = phi * v + rng.normal(0.0, std::sqrt(sigma2 * (1.0 - phi * phi)));
      const double white = next + model.acceleration_gain_s() * (next - v) / dt;
      squares += white * white, products += white * last;
      last = white, v = next;
    }
    // Relative standard deviation of a variance from n draws is √(2/n) = 1 %: five of them.
    EXPECT_NEAR(squares / kSteps / model.innovation_variance(), 1.0, 0.05) << dt;
    EXPECT_NEAR(products / squares, 0.0, 0.036) << dt;  // 5/√n
  }
}

}  // namespace
}  // namespace wayfare
