// Selected blocks of H⁻¹ from the factorisation, and covariances from them.

#include <filesystem>
#include <string>
#include <variant>

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include <wayfare/graph/optimise.hpp>
#include <wayfare/io/g2o.hpp>
#ifdef WAYFARE_TEST_CHOLMOD
#include <wayfare/graph/cholmod_solver.hpp>
#endif

#include "shapes.hpp"
#include "tangle.hpp"

namespace wayfare {
namespace {

using tests::all_shapes;
using tests::fill;

template <class Solver>
class SelectedInverseTest : public ::testing::Test {};
using BlockSizes =
    ::testing::Types<MultifrontalCholesky<2>, MultifrontalCholesky<3>, MultifrontalCholesky<6>>;
TYPED_TEST_SUITE(SelectedInverseTest, BlockSizes);

TYPED_TEST(SelectedInverseTest, EqualsTheDenseInverseInThePatternOfH) {
  constexpr int kBlock = TypeParam::kBlock;
  Rng rng(41);
  for (const auto& shape : all_shapes(rng)) {
    SCOPED_TRACE(shape.name + " of " + std::to_string(shape.columns));
    BlockSparse<kBlock> h(shape.columns, shape.pairs);
    TypeParam solver;
    solver.analyse(h);
    const Eigen::MatrixXd inverse = fill(h, rng).inverse();
    ASSERT_TRUE(solver.factorise(h).ok);
    Eigen::Matrix<double, kBlock, kBlock> got;
    EXPECT_FALSE(solver.inverse_block(0, 0, got));
    solver.invert();
    for (int c = 0; c < h.columns(); ++c) {
      for (int r = 0; r < h.columns(); ++r) {  // the rest, where L has more blocks than H
        if (!solver.inverse_block(r, c, got)) continue;
        EXPECT_LT((got - inverse.block<kBlock, kBlock>(r * kBlock, c * kBlock)).norm(),
                  1e-13 * inverse.norm());
      }
      for (int k = h.starts()[static_cast<std::size_t>(c)]; k <= h.diagonal_index(c); ++k)
        EXPECT_TRUE(solver.inverse_block(h.rows()[static_cast<std::size_t>(k)], c, got));
    }
    Eigen::VectorXd x = Eigen::VectorXd::Ones(inverse.rows());
    solver.solve_in_place(x);  // unchanged by invert()
    EXPECT_LT((inverse * Eigen::VectorXd::Ones(inverse.rows()) - x).norm(), 1e-12 * x.norm());
    ASSERT_TRUE(solver.factorise(h).ok);
    EXPECT_FALSE(solver.inverse_block(0, 0, got));
  }
}

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
    const std::string path = std::string(WAYFARE_DATA_DIR) + "/posegraph/" + name + ".g2o.gz";
    if (!std::filesystem::exists(path)) GTEST_SKIP() << "needs posegraph in WAYFARE_DATA_DIR";
    const auto file = io::read_g2o(path);
    ASSERT_TRUE(file) << file.error().to_string();
    std::visit([](const auto& any) { compare_with_cholmod(io::to_pose_graph(any)); }, *file);
  }
}
#endif

}  // namespace
}  // namespace wayfare
