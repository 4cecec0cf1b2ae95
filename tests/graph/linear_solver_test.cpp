#include <wayfare/graph/linear_solver.hpp>

#include <algorithm>
#include <type_traits>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/SparseCholesky>

#include <wayfare/graph/rank_check.hpp>
#include <wayfare/graph/scalar_solver.hpp>
#include <wayfare/testing/solver_laws.hpp>

#include "core/faults_of.hpp"
#include "solvers.hpp"

namespace wayfare {
namespace {

using testing::random_pairs;

/// Without an own test of anything: what RankCheck makes of it.
class DenseSolver {
 public:
  static constexpr int kBlock = 3;
  void analyse(const BlockSparse<3>&) { rank_.analyse(); }
  FactorOutcome factorise(const BlockSparse<3>& h) {
    llt_.compute(testing::dense(h));
    rank_.start(h);
    return rank_.outcome(h, llt_.info() == Eigen::Success);
  }
  void solve_in_place(Eigen::VectorXd& x) {
    if (x.size() == llt_.rows()) x = llt_.solve(x).eval();  // one that remembers has another size
  }

 private:
  Eigen::LLT<Eigen::MatrixXd> llt_;
  RankCheck<3> rank_;
};

/// Its pivots may be negative.
using LdltSolver = ScalarSolver<2, Eigen::SimplicialLDLT<ScalarExpansion<2>::Matrix, Eigen::Upper,
                                                         Eigen::NaturalOrdering<int>>>;

template <class Solver>
class LinearSolverTest : public ::testing::Test {};
template <class... S>
::testing::Types<S..., MultifrontalCholesky<2>, EigenSolver<2>, LdltSolver, DenseSolver> with_more(
    ::testing::Types<S...>);
TYPED_TEST_SUITE(LinearSolverTest, decltype(with_more(AllSolvers())));

TYPED_TEST(LinearSolverTest, ObeysTheLaws) { testing::SolverLaws<TypeParam>{}.check(); }

/// DenseSolver with a fault.
enum class Fault { none, inexact, keeps_the_matrix, accepts_everything, names_nothing, remembers };
template <Fault kFault>
class Faulty {
 public:
  static constexpr int kBlock = 3;
  void analyse(const BlockSparse<3>& h) {
    if (kFault == Fault::remembers && h_ != nullptr) return;
    solver_.analyse(h);
  }
  FactorOutcome factorise(const BlockSparse<3>& h) {
    h_ = &h;
    if (kFault == Fault::remembers && factorised_) return {};
    factorised_ = true;
    const FactorOutcome outcome = solver_.factorise(h);
    if (kFault == Fault::accepts_everything) return {};
    return kFault == Fault::names_nothing ? FactorOutcome{outcome.ok} : outcome;
  }
  void solve_in_place(Eigen::VectorXd& x) {
    if (kFault == Fault::keeps_the_matrix) (void)solver_.factorise(*h_);
    solver_.solve_in_place(x);
    if (kFault == Fault::inexact) x *= 1.0 + 1e-9;
  }

 private:
  DenseSolver solver_;
  const BlockSparse<3>* h_ = nullptr;
  bool factorised_ = false;
};

template <Fault kFault>
std::string faults(const testing::SolverLaws<Faulty<kFault>>& laws = {}) {
  return testing::faults_of([&] { laws.check(); });
}

TEST(SolverLaws, NameWhatIsWrong) {
  using ::testing::HasSubstr;
  EXPECT_EQ(faults<Fault::none>(), "");
  EXPECT_THAT(faults<Fault::inexact>(), HasSubstr("the solution is wrong"));
  EXPECT_EQ(faults<Fault::inexact>({.tolerance = 1e-8}), "");
  EXPECT_THAT(faults<Fault::keeps_the_matrix>(), HasSubstr("the matrix changed after factorise"));
  EXPECT_THAT(faults<Fault::accepts_everything>(),
              ::testing::AllOf(HasSubstr("on the diagonal of column"), HasSubstr("H = 0"),
                               HasSubstr("nothing determines columns")));
  EXPECT_THAT(faults<Fault::names_nothing>(), HasSubstr("the block that is not determined"));
  EXPECT_EQ(faults<Fault::names_nothing>({.names_block = false, .names_direction = false}), "");
  EXPECT_THAT(faults<Fault::remembers>(), HasSubstr("the solution is wrong"));
}

// The concept requires all three functions, and the outcome of a factorisation.
struct SaysNothing {
  static constexpr int kBlock = 3;
  void analyse(const BlockSparse<3>&) {}
  bool factorise(const BlockSparse<3>&) { return true; }
  void solve_in_place(Eigen::VectorXd&) {}
};
static_assert(!LinearSolver<SaysNothing>);
static_assert(!ThreadedSolver<EigenSolver<3>>);
static_assert(
    LinearSolver<ScalarSolver<3, Eigen::SimplicialLLT<ScalarExpansion<3>::Matrix, Eigen::Upper>>>);

TEST(MinimumDegreeOrder, IsAPermutation) {
  Rng rng(9);
  for (const int columns : {1, 2, 50}) {
    auto position = minimum_degree_order(BlockSparse<6>(columns, random_pairs(rng, columns, 90)));
    std::sort(position.begin(), position.end());
    for (int i = 0; i < columns; ++i) EXPECT_EQ(position[static_cast<std::size_t>(i)], i);
  }
}

TEST(MinimumDegreeOrder, EliminatesTheLeavesOfAStarBeforeItsHub) {
  // Eliminating the hub first would fill the whole matrix.
  std::vector<std::pair<int, int>> star;
  for (int leaf = 1; leaf < 20; ++leaf) star.emplace_back(0, leaf);
  const auto position = minimum_degree_order(BlockSparse<3>(20, star));
  EXPECT_GE(position[0], 18);
}

}  // namespace
}  // namespace wayfare
