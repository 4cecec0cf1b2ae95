// Covariances from selected blocks of H⁻¹, which are a law of the solver.

#include <string>
#include <variant>

#include <gtest/gtest.h>

#include <Eigen/LU>

#include <wayfare/graph/optimise.hpp>
#include <wayfare/io/g2o.hpp>
#ifdef WAYFARE_TEST_CHOLMOD
#include <wayfare/graph/cholmod_solver.hpp>
#endif

#include "io/support.hpp"
#include "tangle.hpp"

namespace wayfare {
namespace {

template <class G>
class CovariancesTest : public ::testing::Test {};
using Groups = ::testing::Types<SE2d, SE3d>;
TYPED_TEST_SUITE(CovariancesTest, Groups);

// The oracle inverts dense equations from numeric Jacobians.
TYPED_TEST(CovariancesTest, OfAllPosesEqualTheDenseInverse) {
  constexpr int kDof = TypeParam::kDof;
  Rng rng(42);
  const auto graph = tests::tangle<TypeParam>(rng);
  NormalEquations<TypeParam> equations;
  equations.set_structure(graph);
  const Eigen::MatrixXd inverse =
      tests::DenseEquations<TypeParam>(graph, equations.free()).hessian.inverse();
  PoseGraphOptimiser<TypeParam> optimiser;
  const auto all = optimiser.covariances(graph);
  ASSERT_TRUE(all);
  ASSERT_EQ(all->size(), graph.poses.size());
  for (int pose = 0; pose < graph.size(); ++pose) {
    const int c = equations.column(pose) * kDof;
    SquareOf<TypeParam> want = SquareOf<TypeParam>::Zero();
    if (c >= 0) want = inverse.block<kDof, kDof>(c, c);
    EXPECT_LT(((*all)[static_cast<std::size_t>(pose)] - want).norm(), 1e-7 * inverse.norm());
  }
  // Relative covariances by look-up and by solving agree.
  PoseGraphOptimiser<TypeParam> solving;
  ASSERT_TRUE(solving.prepare_covariances(graph));
  for (int a = 0; a < graph.size(); ++a)
    for (int b = 0; b < graph.size(); ++b)
      EXPECT_LT(
          (optimiser.relative_covariance(graph, a, b) - solving.relative_covariance(graph, a, b))
              .norm(),
          1e-12 * inverse.norm());
}

TYPED_TEST(CovariancesTest, NameThePoseThatIsNotDetermined) {
  Rng rng(43);
  auto graph = tests::tangle<TypeParam>(rng);
  SquareOf<TypeParam> information = SquareOf<TypeParam>::Identity();
  information(TypeParam::kDof - 1, TypeParam::kDof - 1) = 0.0;
  graph.edges.push_back({4, graph.add_pose(graph.poses[4]), TypeParam(), information});
  const auto all = PoseGraphOptimiser<TypeParam>().covariances(graph);
  ASSERT_FALSE(all);
  EXPECT_NE(all.error().message.find("pose 5 is not fully determined"), std::string::npos);
}

#ifdef WAYFARE_TEST_CHOLMOD
template <class G>
void compare_with_cholmod(const PoseGraph<G>& graph) {
  constexpr int kDof = G::kDof;
  NormalEquations<G> equations;
  equations.set_structure(graph);
  equations.linearise(graph, {});
  MultifrontalCholesky<kDof> ours;
  CholmodSolver<kDof> theirs;
  ours.analyse(equations.hessian());
  theirs.analyse(equations.hessian());
  ASSERT_TRUE(ours.factorise(equations.hessian()).ok);
  ASSERT_TRUE(theirs.factorise(equations.hessian()).ok);
  ours.invert();
  for (std::size_t k = 0; k < graph.edges.size(); k += graph.edges.size() / 7) {
    const auto& e = graph.edges[k];
    const auto got = joint_covariance(equations, ours, e.from, e.to);
    const auto want = joint_covariance(equations, theirs, e.from, e.to);
    EXPECT_LT((got - want).norm(), 1e-7 * want.norm()) << "edge " << k;
  }
}

TEST(SelectedInverse, EqualsCholmodOnRealGraphs) {
  for (const std::string name : {"M3500", "sphere2500"}) {
    WAYFARE_NEEDS_RECORDING(path, "posegraph/" + name + ".g2o.gz");
    const auto file = io::read_g2o(path);
    ASSERT_TRUE(file) << file.error().to_string();
    std::visit([](const auto& any) { compare_with_cholmod(io::to_pose_graph(any)); }, *file);
  }
}
#endif

}  // namespace
}  // namespace wayfare
