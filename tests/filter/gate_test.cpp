#include <wayfare/filter/gates.hpp>

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <wayfare/filter/ekf.hpp>
#include <wayfare/filter/gate.hpp>
#include <wayfare/testing/gate_laws.hpp>

#include "core/faults_of.hpp"

namespace wayfare {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using testing::faults_of;
using testing::GateLaws;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// The first number, or the first two, of a state of three.
struct First {
  double value, variance = 0.25;
  ScalarMeasurement<double, SparseRow<double, 1>> operator()(const Vector3d& x) const {
    return {value - x[0], {{0}, {1.0}}, variance};
  }
};
struct FirstTwo {
  Vector2d value;
  VectorMeasurement<double, 2, SparseRows<double, 2, 2>> operator()(const Vector3d& x) const {
    const Eigen::Matrix2d r{{0.25, 0.05}, {0.05, 0.5}};
    return {value - x.head<2>(), {{0, 1}, Eigen::Matrix2d::Identity()}, r};
  }
};

Ekf<Vector3d> some_filter() {
  Eigen::Matrix3d p;
  p << 4.0, 1.2, -0.3, 1.2, 2.0, 0.5, -0.3, 0.5, 0.7;
  return {Vector3d(1.0, -2.0, 0.5), p};
}

/// Reflected ranges are only ever longer.
struct NoEchoes {
  bool operator()(const Innovation<double, 1>& i) const {
    return i.value < 3.0 * std::sqrt(i.covariance);
  }
};

TEST(Gates, SatisfyTheLawsOfGates) {
  GateLaws<ChiSquareGate>{ChiSquareGate(0.99)}.check();
  GateLaws<ChiSquareGate, 2>{ChiSquareGate(0.99)}.check();
  GateLaws<HuberWeight>{}.check();
  GateLaws<HuberWeight, 2>{}.check();
  GateLaws<NoEchoes>{}.check();
  for (const double at : {1.5, 5.0, 9.0, -90.0, 1e6}) {
    GateLaws<ChiSquareGate>{ChiSquareGate(0.99)}.check_update(some_filter(), First{at});
    GateLaws<HuberWeight>{}.check_update(some_filter(), First{at});
    GateLaws<NoEchoes>{}.check_update(some_filter(), First{at});
    GateLaws<ChiSquareGate, 2>{ChiSquareGate(0.9)}.check_update(some_filter(),
                                                                FirstTwo{{at, 0.5 * at}});
    GateLaws<HuberWeight, 2>{}.check_update(some_filter(), FirstTwo{{at, 0.5 * at}});
  }
}

TEST(Gates, LawsNameWhatIsWrong) {
  using ::testing::HasSubstr;
  const auto faults = [](auto gate) {
    return faults_of([&] { GateLaws<decltype(gate)>{gate}.check(); });
  };
  EXPECT_THAT(faults([](const Innovation<double, 1>& i) { return i.nis > 9.0; }),
              HasSubstr("without an innovation"));
  EXPECT_THAT(faults([](const Innovation<double, 1>& i) { return 1.0 + i.nis; }),
              HasSubstr("weight increases"));
  EXPECT_THAT(faults([](const Innovation<double, 1>& i) { return 1.0 - i.nis; }),
              HasSubstr("weight -"));
}

// Quantiles of χ² with one and two degrees of freedom: 1.959964² and −2 ln 0.05.
TEST(Gates, ChiSquareGateRejectsThatShareOfEveryDimension) {
  const ChiSquareGate gate(0.95);
  EXPECT_TRUE(gate(Innovation<double, 1>{0.0, 1.0, 3.8414}));
  EXPECT_FALSE(gate(Innovation<double, 1>{0.0, 1.0, 3.8415}));
  EXPECT_TRUE(gate(Innovation<double, 2>{{}, {}, 5.9914}));
  EXPECT_FALSE(gate(Innovation<double, 2>{{}, {}, 5.9915}));
}

// Prior 4, R = 0.25 and an innovation of 20.6 = 9.992 σ, σ² = 4.25: with Huber's 2 σ the weight is
// 2/9.992 and R = 1.249, hence the gain 4/5.249.
TEST(Gates, HuberWeightAddsToTheVariance) {
  Ekf<Vector3d> filter = some_filter();
  const auto u = filter.update(First{21.6}, HuberWeight{2.0});
  EXPECT_TRUE(u.accepted);
  EXPECT_DOUBLE_EQ(u.variance, 4.25);
  const double r = 0.25 * (20.6 / std::sqrt(4.25)) / 2.0, gain = 4.0 / (4.0 + r);
  EXPECT_NEAR(filter.state()[0], 1.0 + gain * 20.6, 1e-12);
  EXPECT_NEAR(filter.covariance()(0, 0), gain * r, 1e-12);
}

// Huber's constant of 95 % efficiency: the weight is one up to 1.345 σ, a half at twice that.
TEST(Gates, HuberWeightIsOneUpToItsConstant) {
  const auto weight_at = [](double sigmas) {
    return HuberWeight{}(Innovation<double, 1>{sigmas, 1.0, sigmas * sigmas});
  };
  EXPECT_EQ(weight_at(1.344), 1.0);
  EXPECT_NEAR(weight_at(2.0 * 1.345), 0.5, 1e-12);
}

TEST(Gates, AreNotAskedAboutNumbersThatAreNotFinite) {
  Ekf<Vector3d> filter = some_filter();
  int asked = 0;
  const auto all = [&asked](const auto&) { return ++asked > 0; };
  EXPECT_FALSE(filter.update(First{kNan}, all).accepted);
  EXPECT_FALSE(filter.update(First{1.0, -4.5}, all).accepted);
  EXPECT_FALSE(filter.update(FirstTwo{{1.0, kNan}}, all).accepted);
  EXPECT_EQ(asked, 0);
  EXPECT_FALSE(filter.update(First{1.0}, all, false).accepted);
  EXPECT_EQ(filter.covariance(), some_filter().covariance());
}

// Weights that are none: the measurement is rejected and nothing changes.
TEST(Gates, RejectByAnyWeightThatIsNotPositiveAndFinite) {
  for (const double weight : {0.0, -1.0, kNan, std::numeric_limits<double>::infinity()}) {
    Ekf<Vector3d> filter = some_filter();
    const auto gate = [&](const auto&) { return weight; };
    EXPECT_FALSE(filter.update(First{2.0}, gate).accepted) << weight;
    EXPECT_FALSE(filter.update(FirstTwo{{2.0, 1.0}}, gate).accepted) << weight;
    EXPECT_EQ(filter.state(), some_filter().state());
    EXPECT_EQ(filter.covariance(), some_filter().covariance());
  }
}

// Every lane of a pack has the update of a filter of its own.
TEST(Gates, WeighEveryLaneOfAPack) {
  using P = Pack<double, 4>;
  using One = Eigen::Matrix<P, 1, 1>;
  Ekf<One> lanes(One(P(0.0)), One(P(2.0)));
  P z(0.0);
  const double values[] = {0.5, -40.0, kNan, 7.0};
  for (int lane = 0; lane < 4; ++lane) z.set(lane, values[lane]);
  const auto u = lanes.update(
      [&](const One& x) {
        return ScalarMeasurement<P, SparseRow<P, 1>>{z - x[0], {{0}, {P(1.0)}}, P(0.5)};
      },
      HuberWeight{2.0});
  for (int lane = 0; lane < 4; ++lane) {
    Ekf<Eigen::Matrix<double, 1, 1>> alone(Eigen::Matrix<double, 1, 1>(0.0),
                                           Eigen::Matrix<double, 1, 1>(2.0));
    const auto one = alone.update(
        [&](const auto& x) {
          return ScalarMeasurement<double, SparseRow<double, 1>>{
              values[lane] - x[0], {{0}, {1.0}}, 0.5};
        },
        HuberWeight{2.0});
    EXPECT_EQ(u.accepted[lane], one.accepted);
    EXPECT_EQ(lanes.state()[0][lane], alone.state()[0]);
    EXPECT_EQ(lanes.covariance()(0, 0)[lane], alone.covariance()(0, 0));
  }
}

}  // namespace
}  // namespace wayfare
