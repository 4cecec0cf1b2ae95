// The maps compared with independent oracles: the matrix exponential, power series in extended
// precision, values worked by hand.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>
#include <unsupported/Eigen/MatrixFunctions>

#include <wayfare/core/finite.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/testing/detail/law_inputs.hpp>

namespace wayfare {
namespace {

using std::numbers::pi;
using testing::LawInputs;

static_assert(LieGroup<SO2d> && LieGroup<SE2d> && LieGroup<SO3d> && LieGroup<SE3d>);
static_assert(LieGroup<SE2f> && Manifold<Eigen::Vector3d>);
static_assert(!std::is_constructible_v<SE2d, double, double, double>);
static_assert(!std::is_constructible_v<SO2d, double> && !std::is_constructible_v<SO2d, int>);

TEST(FiniteValue, EveryNumberOfAValueCounts) {
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    EXPECT_FALSE(has_finite_value(SE2d(bad, 0.0, Angle())));
    EXPECT_FALSE(has_finite_value(SE2d(0.0, bad, Angle())));
    EXPECT_FALSE(has_finite_value(SE2d(0.0, 0.0, Angle::radians(bad))));
    EXPECT_FALSE(has_finite_value(SE3d({0.0, 0.0, bad}, SO3d())));
    EXPECT_FALSE(has_finite_value(SO3d::exp({0.0, bad, 0.0})));
    EXPECT_FALSE(has_finite_value(Eigen::Vector3d(0.0, bad, 0.0)));
  }
  EXPECT_TRUE(has_finite_value(SE2d(1e300, -1e300, Angle::degrees(90))));
  EXPECT_TRUE(has_finite_value(SE3d({1.0, 2.0, 3.0}, SO3d::exp({0.1, 0.2, 0.3}))));
  EXPECT_TRUE(has_finite_value(Eigen::Vector3d(1.0, 2.0, 3.0)));
}

Eigen::Matrix2d hat(const SO2d::Tangent& tau) {
  return (Eigen::Matrix2d() << 0, -tau[0], tau[0], 0).finished();
}
Eigen::Matrix3d hat(const SO3d::Tangent& tau) { return skew<double>(tau); }
Eigen::Matrix3d hat2(const SE2d::Tangent& tau) {
  return (Eigen::Matrix3d() << 0, -tau[2], tau[0], tau[2], 0, tau[1], 0, 0, 0).finished();
}
Eigen::Matrix4d hat(const SE3d::Tangent& tau) {
  Eigen::Matrix4d m = Eigen::Matrix4d::Zero();
  m.topLeftCorner<3, 3>() = skew<double>(tau.tail<3>());
  m.topRightCorner<3, 1>() = tau.head<3>();
  return m;
}
template <class G, int N>
Eigen::Matrix<double, N + 1, N + 1> homogeneous(const G& x) {
  Eigen::Matrix<double, N + 1, N + 1> m = Eigen::Matrix<double, N + 1, N + 1>::Identity();
  m.template topLeftCorner<N, N>() = x.rotation().matrix();
  m.template topRightCorner<N, 1>() = x.translation();
  return m;
}

TEST(LieValues, ExpIsTheMatrixExponential) {
  constexpr double kTolerance = 1e-14;
  for (const auto& tau : LawInputs<SO2d>::default_tangents()) {
    EXPECT_LE((SO2d::exp(tau).matrix() - hat(tau).exp()).norm(), kTolerance) << tau.transpose();
  }
  for (const auto& tau : LawInputs<SE2d>::default_tangents()) {
    EXPECT_LE((homogeneous<SE2d, 2>(SE2d::exp(tau)) - hat2(tau).exp()).norm(), kTolerance)
        << tau.transpose();
  }
  for (const auto& tau : LawInputs<SO3d>::default_tangents()) {
    EXPECT_LE((SO3d::exp(tau).matrix() - hat(tau).exp()).norm(), kTolerance) << tau.transpose();
  }
  for (const auto& tau : LawInputs<SE3d>::default_tangents()) {
    EXPECT_LE((homogeneous<SE3d, 3>(SE3d::exp(tau)) - hat(tau).exp()).norm(), kTolerance)
        << tau.transpose();
  }
}

// cₙ(x) = Σ (−x)ᵏ/(n+2k)! in extended precision: for θ up to 2π the largest term is about 2π¹²/12!,
// below 10², so that 40 terms of long double leave 1e-17.
template <int N>
void expect_stumpff_series(double theta) {
  const long double x = static_cast<long double>(theta) * static_cast<long double>(theta);
  long double term = 1.0L;
  for (int i = 2; i <= N; ++i) term /= i;
  long double sum = 0.0L, largest = 0.0L;
  for (int k = 0; k < 40; ++k) {
    sum += term;
    largest = std::max(largest, std::abs(term));
    term *= -x / ((N + 2 * k + 1.0L) * (N + 2 * k + 2.0L));
  }
  // Each step of the recurrence above θ = 0.5 divides a rounding error by x ≥ 0.25.
  double tolerance = 1e-15 * (N < 2 ? 1.0 : N < 4 ? 4.0 : 16.0);
  if constexpr (std::numeric_limits<long double>::digits == std::numeric_limits<double>::digits)
    tolerance += 4.0 * std::numeric_limits<double>::epsilon() * static_cast<double>(largest);
  EXPECT_NEAR(stumpff<N>(theta * theta), static_cast<double>(sum), tolerance) << N << " " << theta;
}
TEST(LieValues, StumpffFunctionsMatchTheirSeries) {
  for (const double theta :
       {0.0, 1e-9, 1e-4, 0.01, 0.1, 0.3, 0.49999, 0.5, 0.50001, 0.7, 1.0, 2.0, 3.0, pi, 4.0, 6.0}) {
    expect_stumpff_series<0>(theta);
    expect_stumpff_series<1>(theta);
    expect_stumpff_series<2>(theta);
    expect_stumpff_series<3>(theta);
    expect_stumpff_series<4>(theta);
    expect_stumpff_series<5>(theta);
  }
}

// Single precision must match double to single rounding, also where a naive quotient such as (1 −
// cos θ)/θ² loses all digits.
TEST(LieValues, SinglePrecisionKeepsItsDigits) {
  for (const auto& tau : LawInputs<SE3d>::default_tangents()) {
    const Eigen::Matrix<float, 6, 1> single = tau.cast<float>();
    const Eigen::Matrix<double, 6, 1> same = single.cast<double>();
    const auto error =
        (SE3<float>::right_jacobian(single).cast<double>() - SE3d::right_jacobian(same)).norm();
    EXPECT_LE(error, 5e-6) << tau.transpose();
  }
}

TEST(LieValues, HalfTurns) {
  EXPECT_EQ(SO2d(Angle::radians(pi)).angle().radians(), pi);
  EXPECT_NEAR(SO2d(Angle::radians(3 * pi)).angle().radians(), pi, 1e-15);
  // Half a turn about each axis: log may take either sign, its length is π and exp undoes it.
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::Quaterniond q(0, 0, 0, 0);
    q.coeffs()[axis] = 1.0;
    const SO3d x(q);
    EXPECT_NEAR(x.log().norm(), pi, 1e-15);
    EXPECT_LE((SO3d::exp(x.log()).matrix() - x.matrix()).norm(), 1e-15);
  }
  // Just past half a turn the opposite direction is shorter.
  const double past = pi + 1e-3;
  const Eigen::Vector3d log = SO3d::exp({0, 0, past}).log();
  EXPECT_NEAR(log[2], past - 2 * pi, 1e-14);
}

TEST(LieValues, OppositeQuaternionsAreTheSameRotation) {
  const Eigen::Quaterniond q = Eigen::Quaterniond(0.3, -0.4, 0.5, 0.6).normalized();
  const Eigen::Quaterniond opposite(-q.w(), -q.x(), -q.y(), -q.z());
  EXPECT_LE((SO3d(q).log() - SO3d(opposite).log()).norm(), 1e-15);
}

TEST(LieValues, QuarterTurnByHand) {
  const SE2d x(1.0, 2.0, 90_deg);
  EXPECT_LE((x * Eigen::Vector2d(3.0, 0.0) - Eigen::Vector2d(1.0, 5.0)).norm(), 1e-15);
  const SE2d inverse = x.inverse();  // −Rᵀt = −(2, −1)
  EXPECT_NEAR(inverse.x(), -2.0, 1e-15);
  EXPECT_NEAR(inverse.y(), 1.0, 1e-15);
  EXPECT_NEAR(inverse.heading().degrees(), -90.0, 1e-13);
  // A quarter circle of radius 1 to the left ends at (1, 1): arc length π/2, rotation π/2.
  const SE2d arc = SE2d::exp({pi / 2, 0.0, pi / 2});
  EXPECT_NEAR(arc.x(), 1.0, 1e-15);
  EXPECT_NEAR(arc.y(), 1.0, 1e-15);
  EXPECT_NEAR(arc.heading().radians(), pi / 2, 1e-15);
}

TEST(LieValues, MatrixAndQuaternionConstructorsAgree) {
  for (const auto& tau : LawInputs<SO3d>::default_tangents()) {
    const SO3d x = SO3d::exp(tau);
    EXPECT_LE(SO3d(x.matrix()).minus(x).norm(), 1e-14) << tau.transpose();
    EXPECT_LE(SO3d(x.quaternion()).minus(x).norm(), 1e-15);
  }
}

TEST(LieValues, AMillionProductsStayOnTheGroup) {
  SO2d plane;
  SO3d space;
  const SO2d turn(0.7_rad);
  const SO3d twist = SO3d::exp({0.1, -0.5, 0.3});
  for (int i = 0; i < 1'000'000; ++i) {
    plane = plane * turn;
    space = space * twist;
  }
  EXPECT_NEAR(plane.cos() * plane.cos() + plane.sin() * plane.sin(), 1.0, 1e-15);
  EXPECT_NEAR(space.quaternion().squaredNorm(), 1.0, 2e-15);
}

TEST(LieValues, InterpolationFollowsTheArc) {
  const SE2d a(1.0, 1.0, 10_deg);
  const SE2d b = a * SE2d::exp({pi / 2, 0.0, pi / 2});
  EXPECT_LE(interpolate(a, b, 0.0).minus(a).norm(), 1e-15);
  EXPECT_LE(interpolate(a, b, 1.0).minus(b).norm(), 1e-15);
  // Half way along the quarter circle: (sin 45°, 1 − cos 45°) ahead of a.
  const SE2d middle = a.inverse() * interpolate(a, b, 0.5);
  EXPECT_NEAR(middle.x(), std::sqrt(0.5), 1e-15);
  EXPECT_NEAR(middle.y(), 1.0 - std::sqrt(0.5), 1e-15);
}

TEST(LieValues, CastsKeepTheElement) {
  const SE3d x = SE3d::exp((SE3d::Tangent() << 1, 2, 3, 0.4, -0.5, 0.6).finished());
  EXPECT_LE(x.cast<float>().cast<double>().minus(x).norm(), 1e-6);
  const SE2d y(1.0, 2.0, 0.5_rad);
  EXPECT_LE(y.cast<float>().cast<double>().minus(y).norm(), 1e-6);
}

TEST(LieValues, BetweenIsTheShortestRotation) {
  const Eigen::Vector3d from(0.3, -2.0, 0.7);
  const Eigen::Vector3d across = from.cross(Eigen::Vector3d(1, 1, 0)).normalized();
  for (const double angle : {0.0, 1e-9, 0.4, 2.0, pi - 1e-3, pi - 1e-6, pi}) {
    const Eigen::Vector3d to = 5.0 * (Eigen::AngleAxisd(angle, across) * from);
    const SO3d turn = SO3d::between(from, to);
    EXPECT_LE((turn * from.normalized() - to.normalized()).norm(), 1e-8) << angle;
    EXPECT_NEAR(turn.log().norm(), angle, 1e-8);
    if (angle > 0 && angle < pi) {
      EXPECT_LE((turn.log() - angle * across).norm(), 1e-8) << angle;
    }
  }
}

}  // namespace
}  // namespace wayfare
