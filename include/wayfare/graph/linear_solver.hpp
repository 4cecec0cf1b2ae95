#pragma once

// What the optimiser asks of a sparse solver, and the ordering they share.

#include <array>
#include <concepts>
#include <vector>

#include <Eigen/Core>
#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>

#include <wayfare/graph/block_sparse.hpp>

namespace wayfare {

/// Whether a matrix could be factorised. It could not where a pivot is nothing but rounding: where
/// the information left along a direction v, once what comes before in the order of elimination
/// has responded, is vᵀHv ≤ 32 ε vᵀDv. D is H's diagonal before elimination, within a block the
/// largest of the numbers that share a unit, and ε the spacing of doubles at 1: H's entries hold
/// rounding errors of a few ε √(D_a D_b), so that vᵀHv could as well be zero. The rule is free of
/// H's scale and of units. All solvers here decide by it.
struct FactorOutcome {
  bool ok = true;
  /// Where not: the block column that is undetermined, or at which H has negative information; −1
  /// where the solver cannot tell.
  int block = -1;
  /// The undetermined direction of that block, of length one; its first numbers. Zero where the
  /// solver cannot tell, or where H is not positive semi-definite.
  std::array<double, 6> direction{};
  /// Where ok: that is by less than four digits; close by, H may be singular.
  bool weak = false;
};

/// A pivot of which elimination leaves less than this part of D, upside down, is looked at more
/// closely. One that is rounding is left less, unless v moves much more elsewhere: a map that turns
/// about a hinge, by the square of its extent in steps, once for each of its block columns.
[[nodiscard]] constexpr double suspicious_loss(int columns) {
  const double n = columns, loss = 1e13 / (n * n);
  return loss < 1e4 ? 1e4 : loss < 4e6 ? loss : 4e6;
}

/// Solves H x = b for a symmetric positive definite H. Meaning (checked by
/// tests/graph/linear_solver_test.cpp): after `analyse(h)` any number of `factorise(h)` with the
/// same pattern and other values; after a successful `factorise`, any number of
/// `solve_in_place(x)`, which turn b into x. `factorise` allocates nothing after its first call
/// where the implementation can help it.
template <class S>
concept LinearSolver = std::default_initializable<S> &&
    requires(S& solver, const BlockSparse<S::kBlock>& h, Eigen::VectorXd& x) {
  solver.analyse(h);
  { solver.factorise(h) } -> std::same_as<FactorOutcome>;
  solver.solve_in_place(x);
};

/// A LinearSolver that factorises on several threads where it is told to, with the same result.
template <class S>
concept ThreadedSolver = LinearSolver<S> && requires(S& solver) {
  solver.set_threads(2);
};

/// A LinearSolver that finds chosen blocks of H⁻¹ together for much less than a solution each:
/// after `invert()`, `inverse_block(row, column, block)` gives at least those of the diagonal and
/// of H's pattern, and false for others and before it.
template <class S>
concept SelectedInverse = LinearSolver<S> &&
    requires(S& solver, const S& found, Eigen::Matrix<double, S::kBlock, S::kBlock>& block) {
  solver.invert();
  { found.inverse_block(0, 0, block) } -> std::same_as<bool>;
};

/// position[i] = the place of block column i in an elimination order of little fill: approximate
/// minimum degree on the graph of blocks, N² times smaller than that of scalars.
template <int N>
[[nodiscard]] std::vector<int> minimum_degree_order(const BlockSparse<N>& h) {
  Eigen::SparseMatrix<char, Eigen::ColMajor, int> pattern(h.columns(), h.columns());
  std::vector<char> ones(static_cast<std::size_t>(h.blocks()), 1);
  const Eigen::Map<const Eigen::SparseMatrix<char, Eigen::ColMajor, int>> upper(
      h.columns(), h.columns(), h.blocks(), h.starts().data(), h.rows().data(), ones.data());
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> order;
  Eigen::AMDOrdering<int>()(upper.selfadjointView<Eigen::Upper>(), order);
  // Eigen gives order[k] = the column eliminated k-th.
  std::vector<int> position(static_cast<std::size_t>(h.columns()));
  for (int k = 0; k < h.columns(); ++k) position[static_cast<std::size_t>(order.indices()[k])] = k;
  return position;
}

}  // namespace wayfare
