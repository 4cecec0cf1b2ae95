#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include <wayfare/graph/linear_solver.hpp>

namespace wayfare {

/// The upper triangle of a permuted block matrix P H Pᵀ in compressed columns of scalars, for
/// solvers without block support. The pattern is built once; `fill` copies the values.
template <int N>
class ScalarExpansion {
 public:
  using Matrix = Eigen::SparseMatrix<double, Eigen::ColMajor, int>;

  /// `position[i]` = new index of block column i.
  void build(const BlockSparse<N>& h, std::vector<int> position) {
    position_ = std::move(position);
    std::vector<Eigen::Triplet<int>> blocks;  // their places in h, below zero if transposed
    blocks.reserve(at(h.blocks()));
    for (int c = 0; c < h.columns(); ++c) {
      for (int i = h.starts()[at(c)]; i < h.starts()[at(c) + 1]; ++i) {
        const int row = position_[at(h.rows()[at(i)])], column = position_[at(c)];
        blocks.emplace_back(std::min(row, column), std::max(row, column),
                            row > column ? -1 - i : i);
      }
    }
    Eigen::SparseMatrix<int> sorted(h.columns(), h.columns());
    sorted.setFromTriplets(blocks.begin(), blocks.end());
    expand(sorted);
  }

  /// Copies the values of a matrix with the pattern of `build`.
  void fill(const BlockSparse<N>& h) {
    std::transform(source_.begin(), source_.end(), matrix_.valuePtr(),
                   [values = h.blocks() > 0 ? h.data(0) : nullptr](int i) { return values[i]; });
  }

  [[nodiscard]] const Matrix& matrix() const { return matrix_; }

  /// The diagonal, in each block the largest of the numbers that share a unit.
  [[nodiscard]] Eigen::VectorXd permuted_scales(const BlockSparse<N>& h) const {
    constexpr int kFirst = kLeadingUnits<N>, kOther = N - kFirst;
    Eigen::VectorXd scales(matrix_.cols());
    for (int c = 0; c < h.columns(); ++c) {
      const auto diagonal = h.block(h.diagonal_index(c)).diagonal();
      auto own = scales.segment<N>(position_[at(c)] * N);
      own.template head<kFirst>().setConstant(diagonal.template head<kFirst>().maxCoeff());
      own.template tail<kOther>().setConstant(diagonal.template tail<kOther>().maxCoeff());
    }
    return scales;
  }

  void permute(const Eigen::VectorXd& x, Eigen::VectorXd& permuted) const {
    permuted.resize(x.size());
    for (std::size_t i = 0; i < position_.size(); ++i) {
      permuted.segment<N>(position_[i] * N) = x.segment<N>(static_cast<int>(i) * N);
    }
  }
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
  std::vector<int> position_;
  std::vector<int> source_;  // of each value, its place in h
};

namespace detail {

/// visit(column, l_jj) for every pivot of L, columns as in the matrix that was factorised.
template <class Decomposition, class Visit>
void each_pivot(const Decomposition& decomposition, Visit visit) {
  if constexpr (requires { decomposition.each_pivot(visit); }) {
    decomposition.each_pivot(visit);
  } else {
    const auto& l = decomposition.matrixL().nestedExpression();
    const auto& from = decomposition.permutationPinv().indices();
    for (Eigen::Index j = 0; j < l.cols(); ++j)  // the diagonal comes first in its column
      visit(from.size() > 0 ? from[j] : static_cast<int>(j), l.valuePtr()[l.outerIndexPtr()[j]]);
  }
}

}  // namespace detail

/// LinearSolver on a scalar decomposition with Eigen's interface (of the upper triangle of a
/// ScalarExpansion<N>::Matrix, without an ordering of its own), in the block ordering shared by all
/// solvers here. Such decompositions test the signs of their pivots and do not report where they
/// failed. If they fail, or if a pivot is small relative to D, MultifrontalCholesky decides by
/// FactorOutcome's rule, at the cost of its factorisation.
template <int N, class Decomposition>
class ScalarSolver {
 public:
  static constexpr int kBlock = N;

  void analyse(const BlockSparse<N>& h);
  FactorOutcome factorise(const BlockSparse<N>& h);
  void solve_in_place(Eigen::VectorXd& x);

 private:
  [[nodiscard]] bool suspicious(const BlockSparse<N>& h) const;

  ScalarExpansion<N> expansion_;
  Decomposition decomposition_;
  std::optional<MultifrontalCholesky<N>> judge_;  // once it is asked
  Eigen::VectorXd permuted_, solved_;
};

template <int N, class Decomposition>
void ScalarSolver<N, Decomposition>::analyse(const BlockSparse<N>& h) {
  expansion_.build(h, minimum_degree_order(h));
  decomposition_.analyzePattern(expansion_.matrix());
  judge_.reset();
}

template <int N, class Decomposition>
FactorOutcome ScalarSolver<N, Decomposition>::factorise(const BlockSparse<N>& h) {
  expansion_.fill(h);
  decomposition_.factorize(expansion_.matrix());
  const bool solved = decomposition_.info() == Eigen::Success;
  if (solved && !suspicious(h)) return {};
  if (!judge_) judge_.emplace().analyse(h);
  FactorOutcome outcome = judge_->factorise(h);
  outcome.ok = outcome.ok && solved;
  return outcome;
}

/// Whether some pivot is small beside the diagonal it was before elimination.
template <int N, class Decomposition>
bool ScalarSolver<N, Decomposition>::suspicious(const BlockSparse<N>& h) const {
  const Eigen::VectorXd scale = expansion_.permuted_scales(h);
  const double loss = suspicious_loss(h.columns());
  bool found = false;
  detail::each_pivot(decomposition_, [&](int column, double pivot) {
    const double most = loss * pivot * pivot;
    found = found || !(scale[column] <= most && std::isfinite(most));
  });
  return found;
}

template <int N, class Decomposition>
void ScalarSolver<N, Decomposition>::solve_in_place(Eigen::VectorXd& x) {
  expansion_.permute(x, permuted_);
  solved_ = decomposition_.solve(permuted_);
  expansion_.unpermute(solved_, x);
}

}  // namespace wayfare
