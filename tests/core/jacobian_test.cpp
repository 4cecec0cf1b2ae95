#include <wayfare/core/jacobian.hpp>

#include <cmath>
#include <tuple>
#include <type_traits>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/core/se2.hpp>

namespace wayfare {
namespace {

struct Automatic {
  using Jacobians = AutomaticJacobians;
};
struct Numeric {
  using Jacobians = NumericJacobians;
};
struct Silent {};  // numeric

/// Values on a manifold: (x y) ⊞ δ has the derivative Ad(y⁻¹) by x and I by y.
template <class Choice>
void expect_jacobians_of_a_product(double tolerance) {
  Rng rng(3);
  const auto some_pose = [&] {
    return SE2d(3.0 * rng.normal(), 3.0 * rng.normal(), Angle::radians(3.0 * rng.normal()));
  };
  for (int trial = 0; trial < 50; ++trial) {
    const SE2d x = some_pose(), y = some_pose();
    JacobianBlocks<SE2d, SE2d, SE2d> by;
    const auto product = [](const auto& a, const auto& b) { return a * b; };
    const SE2d value = differentiate<Choice, SE2d>(product, by, x, y);
    EXPECT_EQ(value.minus(x * y).norm(), 0.0);
    const Eigen::Matrix3d by_x = y.inverse().adjoint();
    const double size = 1.0 + by_x.cwiseAbs().maxCoeff();
    EXPECT_LT((std::get<0>(by) - by_x).cwiseAbs().maxCoeff(), tolerance * size);
    EXPECT_LT((std::get<1>(by) - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(),
              tolerance * size);
  }
}

// Differences of numbers near 10 with a step of 6e-6: 10 ε / 6e-6 = 4e-10 and a few of them.
TEST(Jacobian, OfValuesOnAManifold) {
  expect_jacobians_of_a_product<Automatic>(1e-13);
  expect_jacobians_of_a_product<Numeric>(1e-8);
  expect_jacobians_of_a_product<Silent>(1e-8);
}

// f(p, v) = |p⁻¹ v|: rigid motions keep the norm of v − t, so that f depends on the translation as
// −n and on v as n, with n the unit vector from t to v, in the body's axes for the translation.
TEST(Jacobian, OfAVectorByAPoseAndAPoint) {
  const SE2d pose(1.0, 2.0, Angle::radians(0.7));
  const Eigen::Vector2d point(4.0, 6.0), n(0.6, 0.8);
  using Length = Eigen::Matrix<double, 1, 1>;
  const auto length = [](const auto& p, const auto& v) {
    const auto seen = (p.inverse() * v).eval();
    using std::sqrt;
    return Eigen::Matrix<typename std::remove_cvref_t<decltype(seen)>::Scalar, 1, 1>(
        sqrt(seen[0] * seen[0] + seen[1] * seen[1]));
  };
  JacobianBlocks<Length, SE2d, Eigen::Vector2d> automatic, numeric;
  EXPECT_DOUBLE_EQ((differentiate<Automatic, Length>(length, automatic, pose, point)[0]), 5.0);
  EXPECT_DOUBLE_EQ((differentiate<Silent, Length>(length, numeric, pose, point)[0]), 5.0);
  Eigen::RowVector3d by_pose;
  by_pose << -(pose.rotation().inverse() * n).transpose(), 0.0;
  EXPECT_LT((std::get<0>(automatic) - by_pose).norm(), 1e-14);
  EXPECT_LT((std::get<1>(automatic) - n.transpose()).norm(), 1e-14);
  EXPECT_LT((std::get<0>(numeric) - by_pose).norm(), 1e-9);
  EXPECT_LT((std::get<1>(numeric) - n.transpose()).norm(), 1e-9);
}

}  // namespace
}  // namespace wayfare
