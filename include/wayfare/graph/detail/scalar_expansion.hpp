#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

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

}  // namespace wayfare
