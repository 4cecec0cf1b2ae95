#pragma once

// The requirements of the optimiser on a sparse solver, and the solvers' common ordering.

#include <array>
#include <concepts>
#include <vector>

#include <Eigen/Core>
#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>

#include <wayfare/graph/block_sparse.hpp>

namespace wayfare {

/// Whether a matrix could be factorised. It fails where a pivot is not larger than rounding: where
/// the information that elimination leaves along a direction v satisfies vᵀHv ≤ 32 ε vᵀDv. D is
/// H's diagonal before elimination, within a block the largest of the numbers that share a unit,
/// and ε the spacing of doubles at 1: H's entries have rounding errors of a few ε √(D_a D_b), so
/// that vᵀHv may be zero. The rule does not depend on H's scale or units. All solvers use it.
struct FactorOutcome {
  bool ok = true;
  /// On failure the block column that is undetermined, or at which H has negative information; −1
  /// if the solver does not report it.
  int block = -1;
  /// The undetermined unit direction of that block, in its first entries. Zero if the solver does
  /// not report it, or if H is not positive semi-definite.
  std::array<double, 6> direction{};
  /// On success: by a margin of less than four digits; H may be singular nearby.
  bool weak = false;
};

/// A pivot smaller than D divided by this is examined more closely. A pivot that is rounding is
/// smaller still, unless v is much larger in other blocks: a map that rotates about a hinge, by the
/// square of its extent in steps, once for each of its block columns.
[[nodiscard]] constexpr double suspicious_loss(int columns) {
  const double n = columns, loss = 1e13 / (n * n);
  return loss < 1e4 ? 1e4 : loss < 4e6 ? loss : 4e6;
}

/// Solves H x = b for a symmetric positive definite H. Semantics (checked by
/// tests/graph/linear_solver_test.cpp): after `analyse(h)` any number of `factorise(h)` with the
/// same pattern and other values; after a successful `factorise`, any number of
/// `solve_in_place(x)`, which replaces b by x. `factorise` should not allocate after its first
/// call.
template <class S>
concept LinearSolver = std::default_initializable<S> &&
    requires(S& solver, const BlockSparse<S::kBlock>& h, Eigen::VectorXd& x) {
  solver.analyse(h);
  { solver.factorise(h) } -> std::same_as<FactorOutcome>;
  solver.solve_in_place(x);
};

/// A LinearSolver that can factorise on several threads, with the same result.
template <class S>
concept ThreadedSolver = LinearSolver<S> && requires(S& solver) {
  solver.set_threads(2);
};

/// A LinearSolver that computes selected blocks of H⁻¹ together, much faster than by one solve
/// each: after `invert()`, `inverse_block(row, column, block)` gives at least those of the diagonal
/// and of H's pattern; false for blocks that are not available.
template <class S>
concept SelectedInverse = LinearSolver<S> &&
    requires(S& solver, const S& found, Eigen::Matrix<double, S::kBlock, S::kBlock>& block) {
  solver.invert();
  { found.inverse_block(0, 0, block) } -> std::same_as<bool>;
};

/// position[i] = the index of block column i in a fill-reducing elimination order: approximate
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
