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

namespace cholesky {
class Factor;
}

/// Implementation of MultifrontalCholesky, compiled once for all block sizes and instruction sets.
/// Pattern and values are those of BlockSparse.
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
  std::unique_ptr<cholesky::Factor> factor_;
  int threads_ = 1;
};

/// Number of translations, which come first in a block of a pose.
template <int N>
inline constexpr int kLeadingUnits = N == 6 ? 3 : 2;

/// The default LinearSolver. `factorise` reuses the results of `analyse` and allocates nothing
/// after its first call.
template <int N>
class MultifrontalCholesky {
 public:
  static_assert(N == 2 || N == 3 || N == 6, "the kernels are compiled for these");
  static constexpr int kBlock = N;

  /// The first `leading` numbers of a block share one unit and the others another; needed to tell a
  /// direction without information from one with little (FactorOutcome). Default: those of a pose,
  /// x, y (and z), then angles.
  explicit MultifrontalCholesky(int leading = kLeadingUnits<N>) : leading_(leading) {}

  /// Number of threads of further factorisations, including the caller's; default 1. Small matrices
  /// use one. Results are bit-identical for any number.
  void set_threads(int threads) { factor_.set_threads(threads); }

  void analyse(const BlockSparse<N>& h) { factor_.analyse(h.starts(), h.rows(), N, leading_); }

  FactorOutcome factorise(const BlockSparse<N>& h) {
    return factor_.factorise(h.blocks() > 0 ? h.data(0) : nullptr);
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
  int leading_;
};

static_assert(ThreadedSolver<MultifrontalCholesky<3>>);
static_assert(SelectedInverse<MultifrontalCholesky<3>> && SelectedInverse<MultifrontalCholesky<6>>);

}  // namespace wayfare
