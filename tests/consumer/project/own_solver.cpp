#include "links.hpp"

#include <cmath>
#include <string>

#include <Eigen/Cholesky>
#include <Eigen/SparseCholesky>

#include <wayfare/graph/factor_graph.hpp>
#include <wayfare/graph/optimise.hpp>
#include <wayfare/graph/rank_check.hpp>
#include <wayfare/graph/scalar_solver.hpp>

// Linear solvers of one's own: a dense one, and Eigen's L D Lᵀ by the library's adapter. The
// heights of a staircase, of which each step is measured.
namespace {

using Height = Eigen::Matrix<double, 1, 1>;

struct Step {
  using Variables = wayfare::EdgeVariables<Height, Height>;
  static constexpr int kDim = 1;
  double rise_m = 0.0;
  Height error(const Height& from, const Height& to) const {
    return (to - from - Height(rise_m)) / 0.01;
  }
};

using Stairs = wayfare::FactorGraph<wayfare::Variables<Height>, wayfare::Edges<Step>>;

class DenseSolver {
 public:
  static constexpr int kBlock = 2;
  void analyse(const wayfare::BlockSparse<2>&) { rank_.analyse(); }
  wayfare::FactorOutcome factorise(const wayfare::BlockSparse<2>& h) {
    Eigen::MatrixXd upper = Eigen::MatrixXd::Zero(2 * h.columns(), 2 * h.columns());
    h.each_block([&](int r, int c, int i) { upper.block<2, 2>(2 * r, 2 * c) = h.block(i); });
    llt_.compute(upper.selfadjointView<Eigen::Upper>());
    rank_.start(h);
    const bool solved = llt_.info() == Eigen::Success;
    for (int j = 0; solved && j < upper.cols(); ++j)
      rank_.pivot(j, llt_.matrixLLT()(j, j) * llt_.matrixLLT()(j, j));
    return rank_.outcome(h, solved);
  }
  void solve_in_place(Eigen::VectorXd& x) { llt_.solveInPlace(x); }

 private:
  Eigen::LLT<Eigen::MatrixXd> llt_;
  wayfare::RankCheck<2> rank_;
};

using SparseSolver =
    wayfare::ScalarSolver<2, Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Upper,
                                                   Eigen::NaturalOrdering<int>>>;

/// Steps 0 → 1 → … → 9 of 0.2 m, and from 0 to 9 of 1.89 m: each of the ten takes a tenth of the
/// 0.09 m.
template <class Solver>
bool finds_the_optimum() {
  Stairs stairs;
  for (int i = 0; i < 10; ++i) stairs.add(Height(0.0));
  const auto step = [&](int from, int to, double rise_m) {
    stairs.add(Step{rise_m}, wayfare::VariableId<Height>{from}, wayfare::VariableId<Height>{to});
  };
  for (int i = 0; i < 9; ++i) step(i, i + 1, 0.2);
  step(0, 9, 1.89);
  wayfare::GraphOptimiser<Stairs, Solver> optimiser;
  const auto floating = optimiser.optimise(stairs);
  if (floating || floating.error().message.find("is not fully determined") == std::string::npos)
    return false;
  stairs.fix(wayfare::VariableId<Height>{0});
  if (!optimiser.optimise(stairs)) return false;
  return std::abs(stairs.all<Height>()[9][0] - 1.881) < 1e-9;
}

}  // namespace

bool own_solver() { return finds_the_optimum<DenseSolver>() && finds_the_optimum<SparseSolver>(); }
