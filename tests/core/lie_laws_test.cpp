// The shipped law suites, on every group and on plain vectors, in both precisions.

#include <gtest/gtest-spi.h>
#include <gtest/gtest.h>

#include <wayfare/core/se2.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/testing/lie_group_laws.hpp>

namespace wayfare {
namespace {

using testing::LieGroupLaws;
using testing::ManifoldLaws;

template <class G>
class LieLaws : public ::testing::Test {
 protected:
  LieGroupLaws<G> laws;
};
using Groups = ::testing::Types<SO2<double>, SO2<float>, SE2<double>, SE2<float>, SO3<double>,
                                SO3<float>, SE3<double>, SE3<float>>;
TYPED_TEST_SUITE(LieLaws, Groups);

TYPED_TEST(LieLaws, Manifold) { this->laws.ManifoldLaws<TypeParam>::check(); }
TYPED_TEST(LieLaws, Identity) { this->laws.identity(); }
TYPED_TEST(LieLaws, Inverse) { this->laws.inverse(); }
TYPED_TEST(LieLaws, Associativity) { this->laws.associativity(); }
TYPED_TEST(LieLaws, ExpLogRoundTrip) { this->laws.exp_log_round_trip(); }
TYPED_TEST(LieLaws, Powers) { this->laws.powers(); }
TYPED_TEST(LieLaws, MinusIgnoresACommonLeftFactor) {
  this->laws.minus_ignores_a_common_left_factor();
}
TYPED_TEST(LieLaws, Adjoint) { this->laws.adjoint(); }
TYPED_TEST(LieLaws, RightJacobian) { this->laws.right_jacobian(); }
TYPED_TEST(LieLaws, RightJacobianInverse) { this->laws.right_jacobian_inverse(); }
TYPED_TEST(LieLaws, LeftAndRightJacobians) { this->laws.left_and_right_jacobians(); }
TYPED_TEST(LieLaws, Action) { this->laws.action(); }

template <class V>
class VectorLaws : public ::testing::Test {};
using Vectors = ::testing::Types<Eigen::Matrix<double, 1, 1>, Eigen::Vector3d, Eigen::Vector4f,
                                 Eigen::Matrix<float, 9, 1>>;
TYPED_TEST_SUITE(VectorLaws, Vectors);

TYPED_TEST(VectorLaws, Manifold) { ManifoldLaws<TypeParam>{}.check(); }

// A kilometre from the origin the rounding error of the translation is that of a kilometre.
TEST(LieLaws, AreSatisfiedFarFromTheOrigin) {
  LieGroupLaws<SE2d> laws;
  for (SE2d& x : laws.inputs.points) x = SE2d(1000.0, -2000.0, 0.4_rad) * x;
  laws.inputs.tolerance *= 4000.0;
  laws.check();
}

// The law suite detects a group whose adjoint lacks the lever arm.
struct NoLeverArm : SE2d {
  using SE2d::SE2d;
  NoLeverArm() = default;
  NoLeverArm(const SE2d& x) : SE2d(x) {}  // NOLINT(*-explicit*)
  static NoLeverArm identity() { return {}; }
  static NoLeverArm exp(const Tangent& tau) { return SE2d::exp(tau); }
  [[nodiscard]] NoLeverArm inverse() const { return SE2d::inverse(); }
  NoLeverArm operator*(const NoLeverArm& o) const { return SE2d::operator*(o); }
  [[nodiscard]] NoLeverArm plus(const Tangent& tau) const { return SE2d::plus(tau); }
  [[nodiscard]] Jacobian adjoint() const {
    Jacobian a = SE2d::adjoint();
    a.topRightCorner<2, 1>().setZero();
    return a;
  }
};

TEST(LieLaws, AWrongAdjointIsDetected) {
  const LieGroupLaws<NoLeverArm> laws;
  laws.inverse();
  ::testing::TestPartResultArray failures;
  {
    const ::testing::ScopedFakeTestPartResultReporter collect(
        ::testing::ScopedFakeTestPartResultReporter::INTERCEPT_ONLY_CURRENT_THREAD, &failures);
    laws.adjoint();
  }
  EXPECT_GT(failures.size(), 0);
}

}  // namespace
}  // namespace wayfare
