#include <wayfare/graph/normal_equations.hpp>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>

namespace wayfare {
namespace {

template <class G>
class NormalEquationsTest : public testing::Test {};
using Groups = testing::Types<SE2d, SE3d>;
TYPED_TEST_SUITE(NormalEquationsTest, Groups);

/// Five poses, two of them fixed, joined both ways round, with a doubled edge.
template <class G>
PoseGraph<G> tangle(Rng& rng) {
  const auto random = [&](double scale) {
    TangentOf<G> d;
    for (auto& v : d) v = rng.uniform(-scale, scale);
    return d;
  };
  PoseGraph<G> graph;
  for (int i = 0; i < 5; ++i) graph.add_pose(G::exp(random(1.0)));
  for (const auto& [from, to] : {std::pair{0, 1}, {2, 1}, {3, 2}, {1, 4}, {4, 3}, {1, 4}, {0, 3}}) {
    const auto& a = graph.poses[static_cast<std::size_t>(from)];
    const auto& b = graph.poses[static_cast<std::size_t>(to)];
    const SquareOf<G> root = SquareOf<G>::Identity() + 0.2 * random(1.0) * random(1.0).transpose();
    graph.edges.push_back(
        {from, to, (a.inverse() * b).plus(random(0.3)), root * root.transpose(), from > to});
  }
  graph.fixed = {0, 3};
  return graph;
}

// The gradient of ½ Σ ρ(eᵀΩe) is g, whatever the kernel.
TYPED_TEST(NormalEquationsTest, GradientIsTheNumericalOneOfTheCost) {
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
    for (std::size_t c = 0; c < equations.free_poses().size(); ++c) {
      auto& pose = graph.poses[static_cast<std::size_t>(equations.free_poses()[c])];
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

TYPED_TEST(NormalEquationsTest, StructureIsLaidOutAnewOnlyWhereItChanged) {
  Rng rng(12);
  auto graph = tangle<TypeParam>(rng);
  NormalEquations<TypeParam> equations;
  EXPECT_TRUE(equations.set_structure(graph));
  EXPECT_EQ(equations.free_poses(), (std::vector<int>{1, 2, 4}));
  EXPECT_EQ(equations.free_index(3), -1);
  EXPECT_EQ(equations.hessian().blocks(), 3 + 2);  // 1-2 and 1-4; 4-3 and 3-2 end at a fixed pose
  graph.poses[1] = TypeParam();
  graph.edges[0].information *= 2.0;
  EXPECT_FALSE(equations.set_structure(graph));
  graph.fixed = {0};
  EXPECT_TRUE(equations.set_structure(graph));
  std::swap(graph.edges[1].from, graph.edges[1].to);
  EXPECT_TRUE(equations.set_structure(graph));
  graph.fixed.clear();  // the first pose then holds the graph
  EXPECT_TRUE(equations.set_structure(graph));
  EXPECT_EQ(equations.free_index(0), -1);
}

}  // namespace
}  // namespace wayfare
