#pragma once

// Multifrontal sparse Cholesky H = L Lᵀ on fixed-size blocks: columns of L with similar patterns
// are eliminated together in a dense front, whose update matrix is added to the parent front (Duff,
// Reid 1983, "The multifrontal solution of indefinite sparse symmetric linear systems"; Liu 1992,
// "The multifrontal method for sparse matrix solution"). Ordering and elimination tree are those of
// the graph of blocks, N² times smaller than that of scalars.

#include <Eigen/Core>

#include <wayfare/core/detail/owned.hpp>
#include <wayfare/graph/linear_solver.hpp>

namespace wayfare {

namespace cholesky {
class Factor;
}

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
  void set_threads(int threads);

  void analyse(const BlockSparse<N>& h);
  FactorOutcome factorise(const BlockSparse<N>& h);
  void solve_in_place(Eigen::VectorXd& x);

  /// Computes the blocks of H⁻¹ in the pattern of L, which includes that of H. Requires a
  /// successful `factorise`; costs about twice its time and the same memory again.
  void invert();
  /// Block (row, column) of H⁻¹; false if it was not computed since the last `factorise`.
  bool inverse_block(int row, int column, Eigen::Matrix<double, N, N>& block) const;

 private:
  detail::Owned<cholesky::Factor> factor_{nullptr, nullptr};
  int leading_;
  int threads_ = 1;
};

static_assert(ThreadedSolver<MultifrontalCholesky<3>>);
static_assert(SelectedInverse<MultifrontalCholesky<3>> && SelectedInverse<MultifrontalCholesky<6>>);

}  // namespace wayfare
