#pragma once

// Memory layout of a clique's values, for the dense kernels of the factorisation.

#include <cstddef>

#include <Eigen/Core>

#include "graph/cholesky/kernels.hpp"

namespace wayfare::detail {

/// A clique of blocks of N: `frontals` are eliminated, `separators` coupled to them. Contains the
/// factor's triangle of the frontals and the rectangle below it, the update of the separators
/// (lower triangle), and the right-hand side of both.
template <int N>
class CliqueFront {
 public:
  CliqueFront(double* numbers, int frontals, int separators)
      : frontals_(frontals), separators_(separators) {
    const int pivots = N * frontals, rows = N * separators;
    panel_.pivots = pivots;
    panel_.rows = rows;
    panel_.ld11 = cholesky::padded(pivots);
    panel_.ld21 = cholesky::padded(rows);
    panel_.l11 = numbers;
    panel_.l21 = panel_.l11 + static_cast<std::ptrdiff_t>(panel_.ld11) * pivots;
    update_ = panel_.l21 + static_cast<std::ptrdiff_t>(panel_.ld21) * pivots;
    right_ = update_ + static_cast<std::ptrdiff_t>(panel_.ld21) * rows;
    size_ = static_cast<std::size_t>(right_ - numbers) + static_cast<std::size_t>(pivots + rows);
  }
  /// Number of scalars of a clique.
  static std::size_t size(int frontals, int separators) {
    double none = 0.0;
    return CliqueFront(&none, frontals, separators).size_;
  }

  [[nodiscard]] const cholesky::Panel& panel() const { return panel_; }
  [[nodiscard]] double* update() const { return update_; }
  [[nodiscard]] int frontals() const { return frontals_; }
  [[nodiscard]] int separators() const { return separators_; }
  /// Of frontals, then separators.
  [[nodiscard]] double* right(int slot = 0) const {
    return right_ + static_cast<std::ptrdiff_t>(N) * slot;
  }

  /// The first scalar of block (row, column), row ≥ column, and the stride of its columns.
  [[nodiscard]] double* at(int row, int column, std::ptrdiff_t& stride) const {
    if (row < frontals_) {
      stride = panel_.ld11;
      return panel_.l11 + N * (row + column * stride);
    }
    stride = panel_.ld21;
    if (column < frontals_) return panel_.l21 + N * (row - frontals_ + column * stride);
    return update_ + N * (row - frontals_ + (column - frontals_) * stride);
  }

 private:
  int frontals_, separators_;
  cholesky::Panel panel_{};
  double* update_;
  double* right_;
  std::size_t size_;
};

/// to += from, rows of N columns with strides `to_stride` and `from_stride`.
template <int N>
inline void add_rows(double* to, std::ptrdiff_t to_stride, const double* from,
                     std::ptrdiff_t from_stride, int rows) {
  for (int j = 0; j < N; ++j, to += to_stride, from += from_stride)
    for (int i = 0; i < rows; ++i) to[i] += from[i];
}
/// to += fromᵀ.
template <int N>
inline void add_transposed(double* to, std::ptrdiff_t to_stride, const double* from,
                           std::ptrdiff_t from_stride) {
  for (int j = 0; j < N; ++j, to += to_stride)
    for (int i = 0; i < N; ++i) to[i] += from[j + i * from_stride];
}
/// The lower triangles only.
template <int N>
inline void add_triangle(double* to, std::ptrdiff_t to_stride, const double* from,
                         std::ptrdiff_t from_stride) {
  for (int j = 0; j < N; ++j, to += to_stride, from += from_stride)
    for (int i = j; i < N; ++i) to[i] += from[i];
}

/// Adds a child's update to its parent's front: `slots` are the positions of the child's separators
/// there. Columns that are eliminated in the parent, or the others.
template <int N>
void extend_add(const CliqueFront<N>& parent, const CliqueFront<N>& child, const int* slots,
                bool eliminated) {
  const int size = child.separators();
  const std::ptrdiff_t from_stride = child.panel().ld21;
  int past = size;  // one past the last eliminated one
  while (past > 0 && slots[past - 1] >= parent.frontals()) --past;
  for (int j = 0; j < size; ++j) {
    const int b = slots[j];
    const bool all = b < parent.frontals();
    if (eliminated ? j >= past : all) continue;
    const int end = eliminated && !all ? past : size;
    for (int i = j, run = 1; i < end; i += run, run = 1) {
      const int a = slots[i];
      const bool here = all || a < parent.frontals();
      if (here != eliminated) continue;
      const double* const from = child.update() + N * (i + j * from_stride);
      std::ptrdiff_t stride;
      double* const to = a < b ? parent.at(b, a, stride) : parent.at(a, b, stride);
      if (a == b) {
        add_triangle<N>(to, stride, from, from_stride);
      } else if (a < b) {
        add_transposed<N>(to, stride, from, from_stride);
      } else {
        while (i + run < end && slots[i + run] == a + run && a + run != parent.frontals()) ++run;
        add_rows<N>(to, stride, from, from_stride, N * run);
      }
    }
  }
}

}  // namespace wayfare::detail
