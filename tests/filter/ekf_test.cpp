#include <wayfare/filter/ekf.hpp>

#include <gtest/gtest.h>
#include <Eigen/LU>

#include <wayfare/core/random.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/filter/process_model.hpp>
#include <wayfare/testing/filter_laws.hpp>

namespace wayfare {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using testing::FilterLaws;
using testing::is_covariance;

/// z = h x + noise on a vector.
template <class T, int N>
struct Linear {
  Eigen::Matrix<T, 1, N> h;
  T z, r;
  ScalarMeasurement<T, Eigen::Matrix<T, 1, N>> operator()(const Eigen::Matrix<T, N, 1>& x) const {
    return {z - h.dot(x), h, r};
  }
};

Matrix3d some_covariance() {
  return (Matrix3d() << 4.0, 1.2, -0.3, 1.2, 2.0, 0.5, -0.3, 0.5, 0.7).finished();
}

struct ConstantVelocity {
  double q;
  struct Step {
    Eigen::Vector2d state;
    Eigen::Matrix2d phi, q;
  };
  Step operator()(const Eigen::Vector2d& x, double dt) const {
    const Eigen::Matrix2d phi = (Eigen::Matrix2d() << 1.0, dt, 0.0, 1.0).finished();
    return {phi * x, phi, q * Eigen::Matrix2d::Identity()};
  }
};

TEST(Ekf, SatisfiesTheFilterLaws) {
  const FilterLaws<Vector3d> laws{Ekf<Vector3d>(Vector3d(1.0, -2.0, 0.5), some_covariance())};
  laws.check_update(Linear<double, 3>{{1.0, 0.0, 0.0}, 2.0, 0.25});
  laws.check_update(Linear<double, 3>{{0.3, -1.0, 2.0}, -7.0, 1e-2});
  const FilterLaws<Eigen::Vector2d> moving{
      Ekf<Eigen::Vector2d>(Eigen::Vector2d(0.0, 1.0), some_covariance().topLeftCorner<2, 2>())};
  moving.check_predict(ConstantVelocity{0.1}, 0.5);
}

/// Used or not by the size of the innovation, or with a weight.
struct GivenWeight {
  double weight;
  double operator()(const Innovation<double, 1>&) const { return weight; }
};

// With the noise as a further state, the update is an ordinary one.
TEST(Ekf, NoiseCorrelatedWithTheErrorIsAStateThatIsLeftOut) {
  const Vector3d cross(0.4, -0.2, 0.1);
  Eigen::Matrix4d with_noise;
  with_noise << some_covariance(), cross, cross.transpose(), 0.9;
  const Linear<double, 3> measured{{0.3, -1.0, 2.0}, -7.0, 0.9};
  const Linear<double, 4> of_both{{0.3, -1.0, 2.0, 1.0}, -7.0, 1e-12};
  Ekf<Vector3d> filter(Vector3d(1.0, -2.0, 0.5), some_covariance());
  Ekf<Eigen::Vector4d> both(Eigen::Vector4d(1.0, -2.0, 0.5, 0.0), with_noise);
  const auto u = filter.update_correlated(measured, cross, GivenWeight{1.0});
  const auto expected = both.update(of_both);
  EXPECT_TRUE(u.accepted);
  EXPECT_NEAR(u.variance, expected.variance, 1e-9);
  EXPECT_LT((filter.state() - both.state().head<3>()).norm(), 1e-9);
  EXPECT_LT((filter.covariance() - both.covariance().topLeftCorner<3, 3>()).norm(), 1e-9);
}

TEST(Ekf, TheWeightOfACorrelatedUpdateDividesTheVarianceOfTheInnovation) {
  const Linear<double, 3> measured{{1.0, 0.0, 0.0}, 9.0, 0.5};
  const Ekf<Vector3d> before(Vector3d(1.0, -2.0, 0.5), some_covariance());
  Ekf<Vector3d> filter = before, rejected = before;
  // P = 4, R = 0.5, S = 4.5; with a weight of 1/4: S = 18, gain 4/18, innovation 8.
  filter.update_correlated(measured, Vector3d::Zero(), GivenWeight{0.25});
  EXPECT_NEAR(filter.state()[0], 1.0 + 8.0 * 4.0 / 18.0, 1e-12);
  EXPECT_NEAR(filter.covariance()(0, 0), 4.0 - 16.0 / 18.0, 1e-12);
  EXPECT_FALSE(rejected.update_correlated(measured, Vector3d::Zero(), GivenWeight{0.0}).accepted);
  EXPECT_EQ(rejected.state(), before.state());
  EXPECT_EQ(rejected.covariance(), before.covariance());
}

// A random walk with variance q a step and measurement noise r converges to the positive root of p²
// − p q − q r = 0 for the predicted variance p: the scalar Riccati equation.
TEST(Ekf, ConvergesToTheRiccatiSolution) {
  using State = Eigen::Matrix<double, 1, 1>;
  const double q = 0.3, r = 2.0;
  struct Walk {
    double q;
    struct Step {
      State state, phi, q;
    };
    Step operator()(const State& x) const { return {x, State::Identity(), State(q)}; }
  };
  Ekf<State> filter(State(0.0), State(100.0));
  for (int i = 0; i < 200; ++i) {
    filter.update(Linear<double, 1>{State(1.0), 1.0, r});
    filter.predict(Walk{q});
  }
  EXPECT_NEAR(filter.covariance()(0, 0), 0.5 * (q + std::sqrt(q * q + 4.0 * q * r)), 1e-12);
  EXPECT_NEAR(filter.state()[0], 1.0, 1e-12);
}

// Successive measurements five orders of magnitude more precise than the prediction, in single
// precision with seven digits.
TEST(Ekf, StaysPositiveDefiniteInSinglePrecision) {
  using State = Eigen::Vector3f;
  Eigen::Matrix3f start = 1e4F * Eigen::Matrix3f::Identity();
  Ekf<State> filter(State::Zero(), start);
  Rng rng(3);
  for (int i = 0; i < 300; ++i) {
    Eigen::RowVector3f h;
    for (auto& x : h) x = static_cast<float>(rng.normal());
    filter.update(Linear<float, 3>{h, 1.0F, 0.1F});
    ASSERT_TRUE(is_covariance(filter.covariance())) << "update " << i;
  }
}

// P = a [1 ½; ½ 1] and the first state measured with R = 0.1: P becomes aR/(a + R), half of it, and
// a − ¼ a²/(a + R). The rounding error of P − K S Kᵀ in single precision is 2⁻²⁴ a = 6e-4, 0.6 % of
// R.
TEST(Ekf, IsAccurateInSinglePrecisionAfterASharpMeasurement) {
  for (const float a : {1e4F, 12345.6F}) {
    const Eigen::Matrix2f start{{a, a / 2.0F}, {a / 2.0F, a}};
    Ekf<Eigen::Vector2f> filter(Eigen::Vector2f::Zero(), start);
    ASSERT_TRUE(filter.update(Linear<float, 2>{{1.0F, 0.0F}, 1.0F, 0.1F}).accepted);
    const double p = double{a}, r = double{0.1F}, share = r / (p + r);
    const Eigen::Matrix2d found = filter.covariance().cast<double>();
    EXPECT_NEAR(found(0, 0) / (p * share), 1.0, 1e-5) << a;
    EXPECT_NEAR(found(0, 1) / (0.5 * p * share), 1.0, 1e-5) << a;
    EXPECT_NEAR(found(1, 1) / (p - 0.25 * p * p / (p + r)), 1.0, 1e-5) << a;
    EXPECT_EQ(found(0, 1), found(1, 0));
  }
}

// h P hᵀ = P₀₀ − 4 P₀₁ + 4 P₁₁ = 7.2, and R = 0.8.
TEST(Ekf, PredictsTheSigmaOfAnInnovation) {
  const Ekf<Vector3d> filter(Vector3d(1.0, -2.0, 0.5), some_covariance());
  const Linear<double, 3> model{{1.0, -2.0, 0.0}, 0.0, 0.8};
  EXPECT_NEAR(filter.predicted_sigma(model(filter.state())), std::sqrt(8.0), 1e-12);
}

TEST(Ekf, BlockUpdateEqualsScalarUpdates) {
  const Ekf<Vector3d> start(Vector3d(1.0, -2.0, 0.5), some_covariance());
  const Eigen::Matrix<double, 2, 3> h =
      (Eigen::Matrix<double, 2, 3>() << 1.0, 0.5, 0.0, -0.2, 1.0, 3.0).finished();
  const Eigen::Vector2d z(2.0, -1.0);
  Ekf<Vector3d> block = start, single = start;
  ASSERT_TRUE(block.update_block<2>(z - h * start.state(), h, 0.3 * Eigen::Matrix2d::Identity()));
  for (int i = 0; i < 2; ++i) single.update(Linear<double, 3>{h.row(i), z[i], 0.3});
  EXPECT_TRUE(block.covariance().isApprox(single.covariance(), 1e-12));
  EXPECT_TRUE(block.state().isApprox(single.state(), 1e-12));
  EXPECT_TRUE(is_covariance(block.covariance()));
}

TEST(Ekf, BlockUpdateRejectsOutliers) {
  Ekf<Vector3d> filter(Vector3d::Zero(), some_covariance());
  const Eigen::Matrix<double, 1, 3> h(1.0, 0.0, 0.0);
  using One = Eigen::Matrix<double, 1, 1>;
  EXPECT_FALSE(filter.update_block<1>(One(50.0), h, One(1.0), 25.0));  // 50²/5 = 500
  EXPECT_FALSE(filter.update_block<1>(One(NAN), h, One(1.0)));
  EXPECT_FALSE(filter.update_block<1>(One(1.0), h, One(-10.0)));  // not a covariance
  EXPECT_EQ(filter.covariance(), some_covariance());
  EXPECT_EQ(filter.state(), Vector3d::Zero());
}

// An attitude estimated from the directions to two stars in the body frame, from an initial error
// of 15°. The first rows are linearised at a wrong attitude, so part of the error remains; noise
// alone would leave 0.0016 rad.
TEST(Ekf, EstimatesAnAttitudeOnItsManifold) {
  const SO3d truth = SO3d::exp(Vector3d(0.1, -0.2, 0.15));
  Ekf<SO3d> filter(SO3d::identity(), Matrix3d::Identity());
  for (int round = 0; round < 20; ++round) {
    for (const Vector3d& star : {Vector3d(1, 0, 0), Vector3d(0, 0.6, 0.8)}) {
      const Vector3d seen = truth.inverse() * star;
      for (int axis = 0; axis < 3; ++axis) {
        filter.update([&](const SO3d& q) {
          const Vector3d predicted = q.inverse() * star;
          return ScalarMeasurement<double, Eigen::RowVector3d>{seen[axis] - predicted[axis],
                                                               skew(predicted).row(axis), 1e-4};
        });
      }
    }
  }
  EXPECT_LT(filter.state().minus(truth).norm(), 2e-3);
  EXPECT_TRUE(is_covariance(filter.covariance()));
}

// A pack of eight filters matches eight filters; a rejected, invalid or disabled measurement leaves
// its lane unchanged.
TEST(Ekf, LanesOfAPackAreIndependent) {
  using P = Pack<double, 8>;
  using State = Eigen::Matrix<P, 3, 1>;
  const Matrix3d start = some_covariance();
  Ekf<State> many(State(P(0), P(0), P(0)), start.cast<P>());
  P z;
  for (int i = 0; i < 8; ++i) z.set(i, 0.5 * i);
  z.set(2, 1e6);
  z.set(5, NAN);
  MaskOf<P> enabled(true);
  enabled.set(7, false);
  const Eigen::RowVector3d h(1.0, -0.5, 0.25);
  const auto u = many.update(Linear<P, 3>{h.cast<P>(), z, P(0.5)}, P(5), enabled);
  for (int i = 0; i < 8; ++i) {
    Ekf<Vector3d> one(Vector3d::Zero(), start);
    const bool expected = i != 7 && one.update(Linear<double, 3>{h, z[i], 0.5}, 5.0).accepted;
    EXPECT_EQ(u.accepted[i], expected);
    EXPECT_EQ(expected, i != 2 && i != 5 && i != 7);
    for (int a = 0; a < 3; ++a) {
      EXPECT_NEAR(many.state()[a][i], one.state()[a], 1e-14);
      for (int b = 0; b < 3; ++b)
        EXPECT_NEAR(many.covariance()(a, b)[i], one.covariance()(a, b), 1e-14);
    }
  }
}

TEST(Ekf, ResettingAndScalingKeepACovariance) {
  Ekf<Vector3d> filter(Vector3d::Zero(), some_covariance());
  filter.scale_sigma(0, 2, 3.0);
  EXPECT_NEAR(filter.covariance()(0, 0), 36.0, 1e-12);
  EXPECT_NEAR(filter.covariance()(0, 2), -0.9, 1e-12);
  EXPECT_TRUE(is_covariance(filter.covariance()));
  filter.reset_variance(1, 5.0);
  EXPECT_EQ(filter.covariance().row(1), Eigen::RowVector3d(0.0, 5.0, 0.0));
  EXPECT_TRUE(is_covariance(filter.covariance()));
}

}  // namespace
}  // namespace wayfare
