#pragma once

// Solvers without block support: any sparse decomposition with Eigen's interface is a LinearSolver.

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include <wayfare/graph/linear_solver.hpp>
#include <wayfare/graph/rank_check.hpp>

namespace wayfare {

/// The upper triangle of a permuted block matrix P H Pᵀ in compressed columns of scalars, for
/// solvers without block support. The pattern is built once; `fill` copies the values.
template <int N>
class ScalarExpansion {
 public:
  using Matrix = Eigen::SparseMatrix<double, Eigen::ColMajor, int>;  ///< compressed columns

  /// `position[i]` = new index of block column i.
  void build(const BlockSparse<N>& h, std::vector<int> position) {
    position_ = std::move(position);
    order_.resize(position_.size());
    for (int c = 0; c < h.columns(); ++c) order_[at(position_[at(c)])] = c;
    std::vector<Eigen::Triplet<int>> blocks;  // their places in h, below zero if transposed
    blocks.reserve(at(h.blocks()));
    h.each_block([&](int r, int c, int i) {
      const int row = position_[at(r)], column = position_[at(c)];
      blocks.emplace_back(std::min(row, column), std::max(row, column), row > column ? -1 - i : i);
    });
    Eigen::SparseMatrix<int> sorted(h.columns(), h.columns());
    sorted.setFromTriplets(blocks.begin(), blocks.end());
    expand(sorted);
  }

  /// Copies the values of a matrix with the pattern of `build`.
  void fill(const BlockSparse<N>& h) {
    std::transform(source_.begin(), source_.end(), matrix_.valuePtr(),
                   [values = h.blocks() > 0 ? h.data(0) : nullptr](int i) { return values[i]; });
  }

  /// Of the last `fill`.
  [[nodiscard]] const Matrix& matrix() const { return matrix_; }

  /// The row of H at row `permuted` of the matrix.
  [[nodiscard]] int original(int permuted) const {
    return order_[at(permuted / N)] * N + permuted % N;
  }

  /// x in the order of the matrix.
  void permute(const Eigen::VectorXd& x, Eigen::VectorXd& permuted) const {
    permuted.resize(x.size());
    for (std::size_t i = 0; i < position_.size(); ++i) {
      permuted.segment<N>(position_[i] * N) = x.segment<N>(static_cast<int>(i) * N);
    }
  }
  /// The inverse of permute.
  void unpermute(const Eigen::VectorXd& permuted, Eigen::VectorXd& x) const {
    for (std::size_t i = 0; i < position_.size(); ++i) {
      x.segment<N>(static_cast<int>(i) * N) = permuted.segment<N>(position_[i] * N);
    }
  }

 private:
  void expand(const Eigen::SparseMatrix<int>& blocks) {
    std::vector<int> starts{0}, rows;
    source_.clear();
    rows.reserve(static_cast<std::size_t>(blocks.nonZeros() * N * N));
    source_.reserve(rows.capacity());
    for (int c = 0; c < blocks.cols() * N; ++c) {
      const int k = c % N;
      for (Eigen::SparseMatrix<int>::InnerIterator it(blocks, c / N); it; ++it) {
        const int i = it.value(), height = it.row() == c / N ? k + 1 : N;
        for (int j = 0; j < height; ++j) {
          rows.push_back(static_cast<int>(it.row()) * N + j);
          source_.push_back(i < 0 ? (-1 - i) * N * N + j * N + k : i * N * N + k * N + j);
        }
      }
      starts.push_back(static_cast<int>(rows.size()));
    }
    const std::vector<double> none(rows.size(), 0.0);
    matrix_ = Eigen::Map<const Matrix>(blocks.rows() * N, blocks.cols() * N, starts.back(),
                                       starts.data(), rows.data(), none.data());
  }
  static std::size_t at(int i) { return static_cast<std::size_t>(i); }

  Matrix matrix_;
  std::vector<int> position_, order_;  // inverse of each other
  std::vector<int> source_;            // of each value, its place in h
};

/// A decomposition of the upper triangle of a symmetric sparse matrix, as Eigen's are.
template <class D>
concept SparseDecomposition = std::default_initializable<D> &&
    requires(D& d, const Eigen::SparseMatrix<double>& upper, Eigen::VectorXd& x) {
  d.analyzePattern(upper);
  d.factorize(upper);
  { d.info() == Eigen::Success } -> std::convertible_to<bool>;
  x = d.solve(x);
};

namespace detail {

/// visit(column, pivot) for every pivot of a decomposition that shows them, columns as in the
/// matrix that was factorised.
template <class Decomposition, class Visit>
void each_pivot(const Decomposition& decomposition, Visit visit) {
  if constexpr (requires { decomposition.each_pivot(visit); }) {
    decomposition.each_pivot(visit);
  } else if constexpr (requires { decomposition.permutationPinv(); }) {  // one of Eigen's
    const auto& from = decomposition.permutationPinv().indices();
    const auto column = [&](Eigen::Index j) {
      return from.size() > 0 ? from[j] : static_cast<int>(j);
    };
    if constexpr (requires { decomposition.vectorD(); }) {
      const Eigen::VectorXd d = decomposition.vectorD();
      for (Eigen::Index j = 0; j < d.size(); ++j) visit(column(j), d[j]);
    } else {
      const auto& l = decomposition.matrixL().nestedExpression();
      for (Eigen::Index j = 0; j < l.cols(); ++j) {  // the diagonal comes first in its column
        const double pivot = l.valuePtr()[l.outerIndexPtr()[j]];
        visit(column(j), pivot * pivot);
      }
    }
  }
}

}  // namespace detail

/// LinearSolver on a scalar decomposition (of a ScalarExpansion<N>::Matrix, without an ordering of
/// its own), in the block ordering shared by all solvers here. Such decompositions test the signs
/// of their pivots at most and do not report where they failed: RankCheck decides, from the pivots
/// of Eigen's and of those with a member each_pivot(visit), which calls visit(column, d_jj), d_jj
/// of L D Lᵀ; of others by a second factorisation.
template <int N, SparseDecomposition Decomposition>
class ScalarSolver {
 public:
  static constexpr int kBlock = N;  ///< side of a block

  /// Ordering and symbolic factorisation, from the pattern.
  void analyse(const BlockSparse<N>& h);
  /// Requires `analyse` of the same pattern.
  FactorOutcome factorise(const BlockSparse<N>& h);
  /// Replaces b by H⁻¹b. Requires a successful `factorise`.
  void solve_in_place(Eigen::VectorXd& x);

 private:
  ScalarExpansion<N> expansion_;
  Decomposition decomposition_;
  RankCheck<N> rank_;
  Eigen::VectorXd permuted_, solved_;
};

template <int N, SparseDecomposition Decomposition>
void ScalarSolver<N, Decomposition>::analyse(const BlockSparse<N>& h) {
  expansion_.build(h, minimum_degree_order(h));
  decomposition_.analyzePattern(expansion_.matrix());
  rank_.analyse();
}

template <int N, SparseDecomposition Decomposition>
FactorOutcome ScalarSolver<N, Decomposition>::factorise(const BlockSparse<N>& h) {
  expansion_.fill(h);
  decomposition_.factorize(expansion_.matrix());
  const bool solved = decomposition_.info() == Eigen::Success;
  rank_.start(h);
  if (solved)
    detail::each_pivot(decomposition_, [&](int column, double pivot) {
      rank_.pivot(expansion_.original(column), pivot);
    });
  return rank_.outcome(h, solved);
}

template <int N, SparseDecomposition Decomposition>
void ScalarSolver<N, Decomposition>::solve_in_place(Eigen::VectorXd& x) {
  expansion_.permute(x, permuted_);
  solved_ = decomposition_.solve(permuted_);
  expansion_.unpermute(solved_, x);
}

}  // namespace wayfare
