#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include <wayfare/graph/linear_solver.hpp>
#include <wayfare/graph/multifrontal_cholesky.hpp>

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
    const auto columns = by_column(h);
    allocate(columns);
    target_.assign(static_cast<std::size_t>(h.blocks()) * N, 0);
    int next = 0;
    for (std::size_t c = 0; c < columns.size(); ++c) {
      for (int k = 0; k < N; ++k) next = lay_out_column(columns[c], static_cast<int>(c), k, next);
      matrix_.outerIndexPtr()[(c + 1) * N] = next;
    }
  }

  /// Copies the values of a matrix with the pattern of `build`.
  void fill(const BlockSparse<N>& h) {
    double* values = matrix_.valuePtr();
    for (int c = 0; c < h.columns(); ++c) {
      for (int i = h.starts()[at(c)]; i < h.starts()[at(c) + 1]; ++i) {
        const int r = h.rows()[at(i)];
        const auto block = h.block(i);
        const bool flip = position_[at(r)] > position_[at(c)];
        for (int k = 0; k < N; ++k) {
          const int height = r == c ? k + 1 : N;
          double* column = values + target_[at(i) * N + at(k)];
          for (int j = 0; j < height; ++j) column[j] = flip ? block(k, j) : block(j, k);
        }
      }
    }
  }

  [[nodiscard]] const Matrix& matrix() const { return matrix_; }

  /// The diagonal, in each block the largest of the numbers that share a unit.
  [[nodiscard]] Eigen::VectorXd permuted_scales(const BlockSparse<N>& h, int leading) const {
    Eigen::VectorXd scales(matrix_.cols());
    for (int c = 0; c < h.columns(); ++c) {
      const auto block = h.block(h.diagonal_index(c));
      double most[2] = {0.0, 0.0};
      for (int k = 0; k < N; ++k) {
        double& of_unit = most[k < leading ? 0 : 1];
        of_unit = std::max(of_unit, block(k, k));
      }
      for (int k = 0; k < N; ++k) scales[position_[at(c)] * N + k] = most[k < leading ? 0 : 1];
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
  struct Entry {
    int row;
    int block;
  };
  static std::size_t at(int i) { return static_cast<std::size_t>(i); }

  /// The blocks of each permuted column, rows ascending.
  std::vector<std::vector<Entry>> by_column(const BlockSparse<N>& h) const {
    std::vector<std::vector<Entry>> columns(at(h.columns()));
    for (int c = 0; c < h.columns(); ++c) {
      for (int i = h.starts()[at(c)]; i < h.starts()[at(c) + 1]; ++i) {
        const int a = position_[at(h.rows()[at(i)])], b = position_[at(c)];
        columns[at(std::max(a, b))].push_back({std::min(a, b), i});
      }
    }
    for (auto& column : columns) {
      std::sort(column.begin(), column.end(),
                [](const Entry& x, const Entry& y) { return x.row < y.row; });
    }
    return columns;
  }

  void allocate(const std::vector<std::vector<Entry>>& columns) {
    std::size_t blocks = 0;
    for (const auto& column : columns) blocks += column.size();
    const auto size = static_cast<Eigen::Index>(columns.size() * N);
    const auto above = static_cast<Eigen::Index>((blocks - columns.size()) * N * N);
    matrix_.resize(size, size);
    matrix_.resizeNonZeros(above + size * (N + 1) / 2);
  }

  int lay_out_column(const std::vector<Entry>& column, int c, int k, int next) {
    matrix_.outerIndexPtr()[c * N + k] = next;
    for (const auto& [row, block] : column) {
      target_[at(block) * N + at(k)] = next;
      const int height = row == c ? k + 1 : N;
      for (int j = 0; j < height; ++j) matrix_.innerIndexPtr()[next++] = row * N + j;
    }
    return next;
  }

  std::vector<int> position_;
  std::vector<int> target_;  // index among the values of each column of each block
  Matrix matrix_;
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
  const Eigen::VectorXd scale = expansion_.permuted_scales(h, kLeadingUnits<N>);
  const double loss = suspicious_loss(h.columns());
  bool found = false;
  detail::each_pivot(decomposition_, [&](int column, double pivot) {
    found = found || !(scale[column] <= loss * pivot * pivot);
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
