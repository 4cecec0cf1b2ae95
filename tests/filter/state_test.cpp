#include <wayfare/filter/state.hpp>

#include <cmath>

#include <gtest/gtest.h>

#include <wayfare/filter/process.hpp>
#include <wayfare/testing/state_laws.hpp>

#include "filter/cart.hpp"

namespace wayfare {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using testing::StateLaws;
using tests::Bias, tests::Cart, tests::Clock, tests::Drift, tests::One, tests::Pose, tests::Scale,
    tests::Speed;

struct Input {
  double dt_s, turn_radps, push_mps2;
};

/// The pose, by Jacobians of any kind.
template <class Kind>
struct Drive {
  using Moves = BlockList<Pose>;
  using By = BlockList<Pose, Speed, Bias>;
  using Jacobians = Kind;
  template <class T>
  SE2<T> moved(const SE2<T>& x, const Eigen::Matrix<T, 2, 1>& v, const One<T>& bias,
               const Input& u) const {
    return x.plus({u.dt_s * v[0], u.dt_s * v[1], u.dt_s * (T(u.turn_radps) - bias[0])});
  }
  template <class... X>
  Eigen::Matrix3d noise(const X&...) const {
    return (Eigen::Matrix3d() << 2.0, 0.3, 0.1, 0.3, 1.0, 0.0, 0.1, 0.0, 0.5).finished();
  }
};

/// Two blocks by a coupling that gives its Jacobian as a map, out of the state's order.
struct Push {
  using Moves = BlockList<Scale, Speed>;
  using By = BlockList<Speed, Scale>;
  struct Jacobian {
    double dt_s, push;
    std::tuple<One<double>, Vector2d> operator()(const Vector2d& speed,
                                                 const One<double>& scale) const {
      return {0.9 * scale, speed + dt_s * push * Vector2d(scale[0], 0.0)};
    }
  };
  [[nodiscard]] auto step(const Vector2d& v, const One<double>& scale, const Input& u) const {
    const Jacobian j{u.dt_s, u.push_mps2};
    const Vector2d faster = v + u.dt_s * u.push_mps2 * Vector2d(1.0 + scale[0], 0.0);
    return CoupledStep{std::tuple{One<double>(0.9 * scale), faster}, j,
                       std::tuple{NoNoise{}, Matrix2d{{0.2, 0.1}, {0.1, 0.3}}}};
  }
};
/// The same with all of the Jacobian and the noise as matrices.
struct PushByMatrix : Push {
  [[nodiscard]] auto step(const Vector2d& v, const One<double>& scale, const Input& u) const {
    Eigen::Matrix3d j = Eigen::Matrix3d::Zero(), q = Eigen::Matrix3d::Zero();
    j(0, 2) = 0.9;
    j(1, 0) = j(2, 1) = 1.0;
    j(1, 2) = u.dt_s * u.push_mps2;
    q.bottomRightCorner<2, 2>() = Matrix2d{{0.2, 0.1}, {0.1, 0.3}};
    return CoupledStep{Push::step(v, scale, u).moved, j, q};
  }
};

const Input kInput{0.1, 0.3, 2.0};

template <class... Coupled>
auto process(const Coupled&... coupled) {
  return Process<Cart, Clock, Coupled..., Drift, Bias>{
      Clock{{0.3, 0.1, 0.2}}, coupled..., Drift{{Vector2d(0.1, 0.2)}}, Bias{{0.02, 5.0}}};
}

TEST(State, IsAManifoldOfItsBlocksWithTheirNamesInOrder) {
  StateLaws<Cart>{}.check_state();
  EXPECT_EQ(Cart::kDof, 12);
  EXPECT_EQ(Cart::index<Pose>(), 0);
  EXPECT_EQ(Cart::index<Speed>(), 4);
  EXPECT_EQ(Cart::index<Clock>(), 9);
  EXPECT_EQ(Cart::names()[3], "gyro bias");
  EXPECT_EQ(Cart::names()[11], "clock offset");
}

TEST(State, ValuesAreReadByBlockAndByName) {
  Cart x;
  x.speed_mps = {1.0, 2.0};
  x.get<Bias>()[0] = 0.5;
  EXPECT_EQ(x.get<Speed>(), Vector2d(1.0, 2.0));
  const Cart y = x.plus(Cart::Tangent::Unit(3));
  EXPECT_EQ(y.get<Bias>()[0], 1.5);
  EXPECT_EQ(y.minus(x), Cart::Tangent::Unit(3));
}

TEST(Process, SatisfiesTheLawsWithJacobiansOfEveryKind) {
  const StateLaws<Cart> laws;
  laws.check_process(process(Drive<AutomaticJacobians>{}, Push{}), kInput);
  laws.check_process(process(Drive<NumericJacobians>{}, Push{}), kInput);
  laws.check_process(process(PushByMatrix{}, Drive<AutomaticJacobians>{}), kInput);
}

TEST(Process, KindsOfJacobiansAgree) {
  Cart x;
  x.speed_mps = {3.0, -0.2};
  const auto automatic = process(Drive<AutomaticJacobians>{}, Push{})(x, kInput);
  const auto numeric = process(Drive<NumericJacobians>{}, PushByMatrix{})(x, kInput);
  EXPECT_LT((automatic.phi() - numeric.phi()).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_EQ(automatic.q(), numeric.q());
  EXPECT_EQ(automatic.state.minus(numeric.state).norm(), 0.0);
}

// Φ and Q written down: e^(−0.1/5), σ² (1 − e^(−0.2/5)), density² dt, and the clock's integrals.
TEST(Process, BlocksMoveAsTheirProcessesSay) {
  Cart x;
  x.get<Bias>()[0] = 2.0;
  x.get<Clock>() = Vector3d(1.0, 0.5, -1.0);
  const auto step = process(Drive<AutomaticJacobians>{}, Push{})(x, kInput);
  const auto phi = step.phi(), q = step.q();
  EXPECT_NEAR(phi(3, 3), std::exp(-0.02), 1e-15);
  EXPECT_NEAR(q(3, 3), 4e-4 * (1.0 - std::exp(-0.04)), 1e-15);
  EXPECT_NEAR(step.state.get<Bias>()[0], 2.0 * std::exp(-0.02), 1e-15);
  EXPECT_NEAR(q(7, 7), 0.01 * 0.1, 1e-15);
  EXPECT_NEAR(q(8, 8), 0.04 * 0.1, 1e-15);
  EXPECT_EQ(phi(9, 10), 0.1);
  EXPECT_NEAR(q(9, 9), 0.09 * 0.1 + 0.01 * 1e-3 / 3.0, 1e-15);
  EXPECT_NEAR(q(9, 10), 0.01 * 0.01 / 2.0, 1e-15);
  EXPECT_NEAR(q(11, 11), 0.04 * 0.1, 1e-15);
  EXPECT_EQ(step.state.get<Clock>(), Vector3d(1.05, 0.5, -1.0));
}

TEST(Process, PreparedStepsGiveTheSameBits) {
  auto prepared = process(Drive<AutomaticJacobians>{}, Push{});
  const auto plain = prepared;
  prepared.prepare(0.1);
  for (const double dt_s : {0.1, 0.2}) {
    const Input u{dt_s, 0.3, 2.0};
    EXPECT_EQ(prepared(Cart{}, u).phi(), plain(Cart{}, u).phi());
    EXPECT_EQ(prepared(Cart{}, u).q(), plain(Cart{}, u).q());
  }
}

}  // namespace
}  // namespace wayfare
