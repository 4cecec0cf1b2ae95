#pragma once

// The requirements of the optimiser on a sparse solver, and the solvers' common ordering.
//
// Multifrontal sparse Cholesky H = L Lᵀ on fixed-size blocks: columns of L with similar patterns
// are eliminated together in a dense front, whose update matrix is added to the parent front (Duff,
// Reid 1983, "The multifrontal solution of indefinite sparse symmetric linear systems"; Liu 1992,
// "The multifrontal method for sparse matrix solution"). Ordering and elimination tree are those of
// the graph of blocks, N² times smaller than that of scalars.

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>

#include <wayfare/core/contract.hpp>
#include <wayfare/core/detail/eigen_alignment.hpp>
#include <wayfare/core/detail/owned.hpp>

namespace wayfare {

/// A symmetric matrix of N×N blocks. Stores the upper triangle column by column, rows ascending,
/// the diagonal block last in its column and always present, with both of its triangles. The
/// pattern and the blocks' addresses are constant after construction.
template <int N>
class BlockSparse {
 public:
  static constexpr int kBlock = N;            ///< side of a block
  using Block = Eigen::Matrix<double, N, N>;  ///< N × N

  BlockSparse() = default;

  /// `pairs` lists (row, column) of off-diagonal blocks, in any order, repeats allowed; (r, c) and
  /// (c, r) name the same block. All values are zero.
  BlockSparse(int columns, std::span<const std::pair<int, int>> pairs) {
    // Counting sort by column, then a sort of each column's rows.
    std::vector<int> ends(static_cast<std::size_t>(columns) + 1, 0);
    for (const auto& [r, c] : pairs) {
      WAYFARE_EXPECTS(r != c && r >= 0 && c >= 0 && r < columns && c < columns,
                      "an off-diagonal block lies inside the matrix");
      ++ends[static_cast<std::size_t>(std::max(r, c)) + 1];
    }
    for (std::size_t c = 1; c < ends.size(); ++c) ends[c] += ends[c - 1];
    std::vector<int> rows(pairs.size());
    std::vector<int> next(ends.begin(), ends.end() - 1);
    for (const auto& [r, c] : pairs)
      rows[static_cast<std::size_t>(next[static_cast<std::size_t>(std::max(r, c))]++)] =
          std::min(r, c);
    starts_.reserve(ends.size());
    rows_.reserve(pairs.size() + static_cast<std::size_t>(columns));
    for (int c = 0; c < columns; ++c) {
      const auto first = rows.begin() + ends[static_cast<std::size_t>(c)];
      const auto last = rows.begin() + ends[static_cast<std::size_t>(c) + 1];
      std::sort(first, last);
      rows_.insert(rows_.end(), first, std::unique(first, last));
      rows_.push_back(c);
      starts_.push_back(static_cast<int>(rows_.size()));
    }
    values_.assign(rows_.size() * kStride, 0.0);
  }

  /// Number of block columns, and of rows.
  [[nodiscard]] int columns() const { return static_cast<int>(starts_.size()) - 1; }
  /// Number of stored blocks.
  [[nodiscard]] int blocks() const { return static_cast<int>(rows_.size()); }
  /// Blocks of column c are [starts()[c], starts()[c + 1]).
  [[nodiscard]] std::span<const int> starts() const { return starts_; }
  /// Row of each stored block.
  [[nodiscard]] std::span<const int> rows() const { return rows_; }

  /// The index of block (r, c), r ≤ c, which must be in the pattern.
  [[nodiscard]] int find(int r, int c) const {
    const auto first = rows_.begin() + starts_[static_cast<std::size_t>(c)];
    const auto last = rows_.begin() + starts_[static_cast<std::size_t>(c) + 1];
    const auto it = std::lower_bound(first, last, r);
    WAYFARE_EXPECTS(it != last && *it == r, "the block is in the pattern");
    return static_cast<int>(it - rows_.begin());
  }
  /// Index of the diagonal block of column c.
  [[nodiscard]] int diagonal_index(int c) const {
    return starts_[static_cast<std::size_t>(c) + 1] - 1;
  }
  /// visit(row, column, index) for every stored block.
  template <class Visit>
  void each_block(const Visit& visit) const {
    for (int c = 0; c < columns(); ++c)
      for (int i = starts_[static_cast<std::size_t>(c)]; i <= diagonal_index(c); ++i)
        visit(rows_[static_cast<std::size_t>(i)], c, i);
  }

  /// The numbers of a block, column by column.
  [[nodiscard]] double* data(int index) {
    return values_.data() + static_cast<std::size_t>(index) * kStride;
  }
  /// The numbers of a block, column by column.
  [[nodiscard]] const double* data(int index) const {
    return values_.data() + static_cast<std::size_t>(index) * kStride;
  }
  /// A stored block, to change it.
  [[nodiscard]] Eigen::Map<Block> block(int index) { return Eigen::Map<Block>(data(index)); }
  /// A stored block.
  [[nodiscard]] Eigen::Map<const Block> block(int index) const {
    return Eigen::Map<const Block>(data(index));
  }

  /// Keeps the pattern.
  void set_zero() { std::fill(values_.begin(), values_.end(), 0.0); }

 private:
  static constexpr std::size_t kStride = static_cast<std::size_t>(N) * N;

  std::vector<int> starts_{0};
  std::vector<int> rows_;
  std::vector<double> values_;
};

/// Whether a matrix could be factorised. It fails where a pivot is not larger than rounding: where
/// the information that elimination leaves along a direction v satisfies vᵀHv ≤ 32 ε vᵀDv. D is
/// H's diagonal before elimination, within a block the largest of the numbers that share a unit,
/// and ε the spacing of doubles at 1: H's entries have rounding errors of a few ε √(D_a D_b), so
/// that vᵀHv may be zero. The rule does not depend on H's scale or units. All solvers use it; those
/// of one's own by RankCheck.
struct FactorOutcome {
  bool ok = true;  ///< factorised
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

/// D of FactorOutcome's rule for one block of N, from its diagonal, numbers `stride` apart; the
/// first `leading` share a unit, and so do the others. If H has no information on a unit, its scale
/// is one.
template <int N>
inline void diagonal_scales(const double* diagonal, long stride, int leading, double* d) {
  double most[2] = {0.0, 0.0};
  for (int i = 0; i < N; ++i) {
    double& of_unit = most[i < leading ? 0 : 1];
    of_unit = std::max(of_unit, diagonal[i * stride]);
  }
  for (double& of_unit : most) of_unit = of_unit > 0.0 ? of_unit : 1.0;
  for (int i = 0; i < N; ++i) d[i] = most[i < leading ? 0 : 1];
}

/// Solves H x = b for a symmetric positive definite H. Semantics, checked by testing::SolverLaws:
/// after `analyse(h)`, which reads the pattern only, any number of `factorise(h)` with the same
/// pattern and other values; after a successful `factorise`, any number of `solve_in_place(x)`,
/// which replaces b by x, also where h has changed since. Equal calls give equal bits. A failure is
/// reported by FactorOutcome's rule. `factorise` should not allocate after its first call.
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
  static constexpr int kBlock = N;  ///< side of a block

  /// The first `leading` numbers of a block share one unit and the others another; needed to tell a
  /// direction without information from one with little (FactorOutcome). Default: those of a pose,
  /// x, y (and z), then angles.
  explicit MultifrontalCholesky(int leading = kLeadingUnits<N>) : leading_(leading) {}

  /// Number of threads of further factorisations, including the caller's; default 1. Small matrices
  /// use one. Results are bit-identical for any number.
  void set_threads(int threads);

  /// Ordering and symbolic factorisation, from the pattern.
  void analyse(const BlockSparse<N>& h);
  /// H = L Lᵀ. Requires `analyse` of the same pattern.
  FactorOutcome factorise(const BlockSparse<N>& h);
  /// Replaces b by H⁻¹b. Requires a successful `factorise`.
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
