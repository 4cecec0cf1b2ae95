#pragma once

// Multifrontal sparse Cholesky H = L Lᵀ on fixed-size blocks: columns of L with similar patterns
// are eliminated together in a dense front, whose update matrix is added to the parent front (Duff,
// Reid 1983, "The multifrontal solution of indefinite sparse symmetric linear systems"; Liu 1992,
// "The multifrontal method for sparse matrix solution"). Ordering and elimination tree are those of
// the graph of blocks, N² times smaller than that of scalars.

#include <memory>
#include <span>

#include <Eigen/Core>

#include <wayfare/graph/linear_solver.hpp>

namespace wayfare {

/// Implementation of MultifrontalCholesky, compiled once for all block sizes and instruction sets.
/// Pattern and values are those of BlockSparse.
class MultifrontalFactor {
 public:
  MultifrontalFactor();
  MultifrontalFactor(MultifrontalFactor&&) noexcept;
  MultifrontalFactor& operator=(MultifrontalFactor&&) noexcept;
  ~MultifrontalFactor();

  void analyse(std::span<const int> starts, std::span<const int> rows, int block);
  void set_threads(int threads);
  /// The block column at which the matrix stops being positive definite, or −1.
  int factorise(const double* values);
  void solve_in_place(double* x);
  void invert();
  bool inverse_block(int row, int column, double* out) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The default LinearSolver. `factorise` reuses the results of `analyse` and allocates nothing
/// after its first call.
template <int N>
class MultifrontalCholesky {
 public:
  static_assert(N == 2 || N == 3 || N == 6, "the kernels are compiled for these");
  static constexpr int kBlock = N;

  /// Number of threads of further factorisations, including the caller's; default 1. Small matrices
  /// use one. Results are bit-identical for any number.
  void set_threads(int threads) { factor_.set_threads(threads); }

  void analyse(const BlockSparse<N>& h) { factor_.analyse(h.starts(), h.rows(), N); }

  FactorOutcome factorise(const BlockSparse<N>& h) {
    const int failed = factor_.factorise(h.blocks() > 0 ? h.data(0) : nullptr);
    return {failed < 0, failed};
  }

  void solve_in_place(Eigen::VectorXd& x) { factor_.solve_in_place(x.data()); }

  /// Computes the blocks of H⁻¹ in the pattern of L, which includes that of H. Requires a
  /// successful `factorise`; costs about twice its time and the same memory again.
  void invert() { factor_.invert(); }
  /// Block (row, column) of H⁻¹; false if it was not computed since the last `factorise`.
  bool inverse_block(int row, int column, Eigen::Matrix<double, N, N>& block) const {
    return factor_.inverse_block(row, column, block.data());
  }

 private:
  MultifrontalFactor factor_;
};

static_assert(ThreadedSolver<MultifrontalCholesky<3>>);
static_assert(SelectedInverse<MultifrontalCholesky<3>> && SelectedInverse<MultifrontalCholesky<6>>);

}  // namespace wayfare
