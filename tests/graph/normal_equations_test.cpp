#include <wayfare/graph/detail/normal_equations.hpp>

#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

#include <wayfare/testing/detail/block_matrices.hpp>
#include "tangle.hpp"

namespace wayfare {
namespace {

using tests::tangle;

template <class G>
class NormalEquationsTest : public ::testing::Test {};
using Groups = ::testing::Types<SE2d, SE3d>;
TYPED_TEST_SUITE(NormalEquationsTest, Groups);

// The gradient of ½ Σ ρ(eᵀΩe) is g for any kernel.
TYPED_TEST(NormalEquationsTest, GradientEqualsTheNumericalOneOfTheCost) {
  constexpr int kDof = TypeParam::kDof;
  constexpr double kStep = 1e-6;
  Rng rng(11);
  for (const auto kind :
       {RobustKernelKind::none, RobustKernelKind::huber, RobustKernelKind::cauchy,
        RobustKernelKind::geman_mcclure, RobustKernelKind::dynamic_covariance_scaling}) {
    const RobustKernel kernel{kind, 0.4};
    auto graph = tangle<TypeParam>(rng);
    NormalEquations<TypeParam> equations, moved;
    equations.set_structure(graph);
    moved.set_structure(graph);
    equations.linearise(graph, kernel);
    for (std::size_t c = 0; c < equations.free().size(); ++c) {
      auto& pose = graph.poses[static_cast<std::size_t>(equations.free()[c])];
      const TypeParam kept = pose;
      for (int k = 0; k < kDof; ++k) {
        const auto cost_at = [&](double step) {
          pose = kept.plus(step * TangentOf<TypeParam>::Unit(k));
          return moved.linearise(graph, kernel);
        };
        const double slope = 0.5 * (cost_at(kStep) - cost_at(-kStep)) / (2.0 * kStep);
        EXPECT_NEAR(equations.gradient()[static_cast<Eigen::Index>(c) * kDof + k], slope, 1e-7);
        pose = kept;
      }
    }
  }
}

TYPED_TEST(NormalEquationsTest, EqualThoseOfNumericJacobians) {
  Rng rng(13);
  for (int round = 0; round < 10; ++round) {
    auto graph = tangle<TypeParam>(rng);
    NormalEquations<TypeParam> equations;
    equations.set_structure(graph);
    equations.linearise(graph, {});
    const tests::DenseEquations<TypeParam> want(graph, equations.free());
    const Eigen::MatrixXd whole = testing::dense(equations.hessian());
    EXPECT_LT((whole - want.hessian).norm(), 1e-8 * want.hessian.norm());
    EXPECT_LT((equations.gradient() - want.gradient).norm(), 1e-8 * want.gradient.norm());
  }
}

// The second derivative of a non-convex kernel is negative: of dynamic covariance scaling beyond Φ,
// of Cauchy and Geman-McClure beyond c. H omits it.
TYPED_TEST(NormalEquationsTest, HessianIsPositiveForLargeErrors) {
  Rng rng(14);
  for (const auto kind : {RobustKernelKind::cauchy, RobustKernelKind::geman_mcclure,
                          RobustKernelKind::dynamic_covariance_scaling}) {
    for (const double size : {0.1, 1.0, 10.0, 1000.0}) {
      auto graph = tangle<TypeParam>(rng);
      for (auto& edge : graph.edges) {
        edge.robust = true;
        edge.measurement = TypeParam::exp(tests::random_tangent<TypeParam>(rng, size));
      }
      NormalEquations<TypeParam> equations;
      equations.set_structure(graph);
      equations.linearise(graph, {kind, 0.5});
      const Eigen::MatrixXd whole = testing::dense(equations.hessian());
      const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(whole, Eigen::EigenvaluesOnly);
      EXPECT_GT(eigen.eigenvalues()[0], 0.0) << static_cast<int>(kind) << " at " << size;
    }
  }
}

TYPED_TEST(NormalEquationsTest, WeightsActLikeRepeatedEdges) {
  Rng rng(15);
  auto graph = tangle<TypeParam>(rng);
  std::vector<double> weights(graph.edges.size(), 1.0);
  weights[2] = 0.0, weights[4] = 2.0;
  NormalEquations<TypeParam> weighted, plain;
  weighted.set_structure(graph);
  weighted.set_weights(weights);
  const double cost = weighted.linearise(graph, {});
  EXPECT_NEAR(weighted.cost(graph, {}), cost, 1e-12 * cost);
  EXPECT_NEAR(weighted.chi2(), chi2(graph), 1e-12 * cost) << "knows no weights";
  auto other = graph;
  other.edges.push_back(other.edges[4]);
  other.edges.erase(other.edges.begin() + 2);
  plain.set_structure(other);
  EXPECT_NEAR(plain.linearise(other, {}), cost, 1e-12 * cost);
  const Eigen::MatrixXd want = testing::dense(plain.hessian());
  // The pattern includes edges of zero weight.
  EXPECT_LT((testing::dense(weighted.hessian()) - want).norm(), 1e-12 * want.norm());
  EXPECT_LT((weighted.gradient() - plain.gradient()).norm(), 1e-12 * plain.gradient().norm());
}

TYPED_TEST(NormalEquationsTest, StructureIsRebuiltOnlyIfItChanged) {
  Rng rng(12);
  auto graph = tangle<TypeParam>(rng);
  NormalEquations<TypeParam> equations;
  EXPECT_TRUE(equations.set_structure(graph));
  EXPECT_EQ(equations.free(), (std::vector<int>{1, 2, 4}));
  EXPECT_EQ(equations.column(3), -1);
  EXPECT_EQ(equations.hessian().blocks(), 3 + 2);  // 1-2 and 1-4; 4-3 and 3-2 end at a fixed pose
  graph.poses[1] = TypeParam();
  graph.edges[0].information *= 2.0;
  EXPECT_FALSE(equations.set_structure(graph));
  graph.fixed = {0};
  EXPECT_TRUE(equations.set_structure(graph));
  std::swap(graph.edges[1].from, graph.edges[1].to);
  EXPECT_TRUE(equations.set_structure(graph));
  graph.fixed.clear();  // then the first pose is fixed
  EXPECT_TRUE(equations.set_structure(graph));
  EXPECT_EQ(equations.column(0), -1);
}

}  // namespace
}  // namespace wayfare
