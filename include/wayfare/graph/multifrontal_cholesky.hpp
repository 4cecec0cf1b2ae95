#pragma once

// Sparse Cholesky H = L Lᵀ on fixed-size blocks, in dense fronts: columns of L that look alike are
// eliminated together in one dense matrix, and what that leaves for later columns is added to the
// front that eliminates the next of them (Duff, Reid 1983, "The multifrontal solution of indefinite
// sparse symmetric linear systems"; Liu 1992, "The multifrontal method for sparse matrix
// solution"). Ordering and elimination tree are found on the graph of blocks, N² times smaller than
// that of scalars.

#include <memory>
#include <span>

#include <Eigen/Core>

#include <wayfare/graph/linear_solver.hpp>

namespace wayfare {

/// The work of MultifrontalCholesky, compiled once for all block sizes and for the instruction sets
/// of this machine. A pattern is that of BlockSparse; values are its blocks, one after another.
class MultifrontalFactor {
 public:
  MultifrontalFactor();
  MultifrontalFactor(MultifrontalFactor&&) noexcept;
  MultifrontalFactor& operator=(MultifrontalFactor&&) noexcept;
  ~MultifrontalFactor();

  /// The first `leading` numbers of a block share one unit, the others another.
  void analyse(std::span<const int> starts, std::span<const int> rows, int block, int leading);
  void set_threads(int threads);
  FactorOutcome factorise(const double* values);
  void solve_in_place(double* x);
  void invert();
  bool inverse_block(int row, int column, double* out) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Translations come first in a block of poses.
template <int N>
inline constexpr int kLeadingUnits = N == 6 ? 3 : 2;

/// LinearSolver of our own. Everything found in `analyse` is kept while only values change, and
/// nothing is allocated after the first `factorise`.
template <int N>
class MultifrontalCholesky {
 public:
  static_assert(N == 2 || N == 3 || N == 6, "the kernels are compiled for these");
  static constexpr int kBlock = N;

  /// The first `leading` numbers of a block share one unit and the others another, which is how a
  /// direction without information is told from one with little (FactorOutcome). By default those
  /// of a pose: x, y (and z), then angles.
  explicit MultifrontalCholesky(int leading = kLeadingUnits<N>) : leading_(leading) {}

  /// Threads that further factorisations may use, at least one (the default), of which all but the
  /// caller's are kept waiting; a small matrix stays with one. Results are the same bits for any.
  void set_threads(int threads) { factor_.set_threads(threads); }

  void analyse(const BlockSparse<N>& h) { factor_.analyse(h.starts(), h.rows(), N, leading_); }

  FactorOutcome factorise(const BlockSparse<N>& h) {
    return factor_.factorise(h.blocks() > 0 ? h.data(0) : nullptr);
  }

  void solve_in_place(Eigen::VectorXd& x) { factor_.solve_in_place(x.data()); }

  /// Finds the blocks of H⁻¹ wherever L has a block: on the diagonal, wherever H has one, and more.
  /// After a successful `factorise`; costs about twice as much and as much memory again.
  void invert() { factor_.invert(); }
  /// Block (row, column) of H⁻¹; false where it was not found, or not since the last `factorise`.
  bool inverse_block(int row, int column, Eigen::Matrix<double, N, N>& block) const {
    return factor_.inverse_block(row, column, block.data());
  }

 private:
  MultifrontalFactor factor_;
  int leading_;
};

static_assert(ThreadedSolver<MultifrontalCholesky<3>>);
static_assert(SelectedInverse<MultifrontalCholesky<3>> && SelectedInverse<MultifrontalCholesky<6>>);

}  // namespace wayfare
