#include <wayfare/graph/detail/damped_step.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/Cholesky>

#include <wayfare/graph/linear_solver.hpp>

#include "tangle.hpp"

namespace wayfare {
namespace {

using tests::DenseEquations;
using tests::tangle;

template <class G>
using Step = DampedStep<PoseGraph<G>, MultifrontalCholesky<ManifoldTraits<G>::kDof>>;

template <class G>
class DampedStepTest : public ::testing::Test {
 protected:
  Rng rng_{21};
  PoseGraph<G> graph_ = tangle<G>(rng_);
  Step<G> step_;
};
using Groups = ::testing::Types<SE2d, SE3d>;
TYPED_TEST_SUITE(DampedStepTest, Groups);

// The oracle solves (H + λ diag H) Δ = −g with dense matrices from numeric Jacobians.
TYPED_TEST(DampedStepTest, SolvesTheDampedEquations) {
  EXPECT_FALSE(this->step_.prepare(this->graph_));
  EXPECT_TRUE(this->step_.prepare(this->graph_));
  this->step_.linearise(this->graph_, {});
  const auto& free = this->step_.equations().free();
  const DenseEquations<TypeParam> want(this->graph_, free);
  for (const double damping : {0.0, 1e-3, 10.0}) {  // each step restores the equations
    Eigen::MatrixXd damped = want.hessian;
    damped.diagonal() *= 1.0 + damping;
    const Eigen::VectorXd delta = -damped.llt().solve(want.gradient);
    ASSERT_TRUE(this->step_.compute(damping));
    EXPECT_NEAR(this->step_.largest(), delta.cwiseAbs().maxCoeff(), 1e-7);
    const double fall = -2.0 * want.gradient.dot(delta) - delta.dot(want.hessian * delta);
    EXPECT_NEAR(this->step_.model_gain(), fall, 1e-7 * std::abs(fall));
    auto moved = this->graph_;
    this->step_.apply(moved);
    for (std::size_t k = 0; k < free.size(); ++k) {
      const auto i = static_cast<std::size_t>(free[k]);
      const auto by = moved.poses[i].minus(this->graph_.poses[i]);
      const auto at = static_cast<Eigen::Index>(k) * TypeParam::kDof;
      EXPECT_LT((by - delta.segment(at, TypeParam::kDof)).norm(), 1e-7);
    }
    for (const int fixed : this->graph_.fixed) {
      const auto i = static_cast<std::size_t>(fixed);
      EXPECT_EQ(moved.poses[i].minus(this->graph_.poses[i]).norm(), 0.0);
    }
    this->step_.undo(moved);
    for (std::size_t i = 0; i < moved.poses.size(); ++i)
      EXPECT_EQ(moved.poses[i].minus(this->graph_.poses[i]).norm(), 0.0);
  }
}

TYPED_TEST(DampedStepTest, NamesAPoseWithoutEdges) {
  this->graph_.labels = {"a", "b", "c", "d", "e"};
  for (auto& edge : this->graph_.edges)
    if (edge.from == 4 || edge.to == 4) edge.information.setZero();
  this->step_.prepare(this->graph_);
  this->step_.linearise(this->graph_, {});
  EXPECT_FALSE(this->step_.compute(0.0));
  EXPECT_FALSE(this->step_.solved());
  EXPECT_THAT(this->step_.undetermined(this->graph_).message,
              ::testing::HasSubstr("pose e is not fully determined"));
}

TYPED_TEST(DampedStepTest, NamesThePoseWithAnOverflow) {
  for (auto& edge : this->graph_.edges)
    if (edge.from == 2 && edge.to == 1) edge.information *= 1e308;
  this->step_.prepare(this->graph_);
  this->step_.linearise(this->graph_, {});
  EXPECT_FALSE(this->step_.compute(0.0));
  const Error error = this->step_.undetermined(this->graph_);
  EXPECT_THAT(error.message,
              ::testing::AnyOf(::testing::HasSubstr("pose 1"), ::testing::HasSubstr("pose 2")));
}

// Rows and columns of the dense inverse; zero for fixed poses.
TYPED_TEST(DampedStepTest, JointCovarianceEqualsTheDenseInverse) {
  constexpr int kDof = TypeParam::kDof;
  this->step_.prepare(this->graph_);
  this->step_.linearise(this->graph_, {});
  ASSERT_TRUE(this->step_.factorise());
  const auto& equations = this->step_.equations();
  const DenseEquations<TypeParam> dense(this->graph_, equations.free());
  const Eigen::MatrixXd inverse = dense.hessian.inverse();
  for (int a = 0; a < this->graph_.size(); ++a) {
    for (int b = 0; b < this->graph_.size(); ++b) {
      const auto joint = joint_covariance(equations, this->step_.solver(), a, b);
      const int columns[2] = {equations.column(a), equations.column(b)};
      for (int row = 0; row < 2; ++row) {
        for (int side = 0; side < 2; ++side) {
          SquareOf<TypeParam> want = SquareOf<TypeParam>::Zero();
          if (columns[row] >= 0 && columns[side] >= 0)
            want = inverse.block<kDof, kDof>(columns[row] * kDof, columns[side] * kDof);
          const SquareOf<TypeParam> got = joint.template block<kDof, kDof>(row * kDof, side * kDof);
          EXPECT_LT((got - want).norm(), 1e-7 * inverse.norm()) << a << ' ' << b;
        }
      }
    }
  }
}

}  // namespace
}  // namespace wayfare
