#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/contract.hpp>

namespace wayfare {

/// A symmetric matrix of N×N blocks of which the upper triangle is kept, column by column, rows
/// ascending, the diagonal block last in its column and always present. The pattern is set once;
/// after that only values change, and the address of a block stays what it is.
template <int N>
class BlockSparse {
 public:
  static constexpr int kBlock = N;
  using Block = Eigen::Matrix<double, N, N>;

  BlockSparse() = default;

  /// `pairs` lists (row, column) of off-diagonal blocks, in any order, repeats allowed; (r, c) and
  /// (c, r) name the same block. All values are zero.
  BlockSparse(int columns, std::span<const std::pair<int, int>> pairs) : starts_(1, 0) {
    std::vector<std::pair<int, int>> upper;  // (column, row)
    upper.reserve(pairs.size() + static_cast<std::size_t>(columns));
    for (const auto& [r, c] : pairs) {
      WAYFARE_EXPECTS(r != c && r >= 0 && c >= 0 && r < columns && c < columns,
                      "an off-diagonal block lies inside the matrix");
      upper.emplace_back(std::max(r, c), std::min(r, c));
    }
    for (int i = 0; i < columns; ++i) upper.emplace_back(i, i);
    std::sort(upper.begin(), upper.end());
    upper.erase(std::unique(upper.begin(), upper.end()), upper.end());
    rows_.reserve(upper.size());
    for (const auto& [c, r] : upper) {
      rows_.push_back(r);
      if (c == r) starts_.push_back(static_cast<int>(rows_.size()));
    }
    values_.assign(upper.size() * kStride, 0.0);
  }

  [[nodiscard]] int columns() const { return static_cast<int>(starts_.size()) - 1; }
  [[nodiscard]] int blocks() const { return static_cast<int>(rows_.size()); }
  /// Blocks of column c are [starts()[c], starts()[c + 1]).
  [[nodiscard]] std::span<const int> starts() const { return starts_; }
  [[nodiscard]] std::span<const int> rows() const { return rows_; }

  /// The index of block (r, c), r ≤ c, which must be in the pattern.
  [[nodiscard]] int find(int r, int c) const {
    const auto first = rows_.begin() + starts_[static_cast<std::size_t>(c)];
    const auto last = rows_.begin() + starts_[static_cast<std::size_t>(c) + 1];
    const auto it = std::lower_bound(first, last, r);
    WAYFARE_EXPECTS(it != last && *it == r, "the block is in the pattern");
    return static_cast<int>(it - rows_.begin());
  }
  [[nodiscard]] int diagonal_index(int c) const {
    return starts_[static_cast<std::size_t>(c) + 1] - 1;
  }

  [[nodiscard]] double* data(int index) {
    return values_.data() + static_cast<std::size_t>(index) * kStride;
  }
  [[nodiscard]] const double* data(int index) const {
    return values_.data() + static_cast<std::size_t>(index) * kStride;
  }
  [[nodiscard]] Eigen::Map<Block> block(int index) { return Eigen::Map<Block>(data(index)); }
  [[nodiscard]] Eigen::Map<const Block> block(int index) const {
    return Eigen::Map<const Block>(data(index));
  }

  void set_zero() { std::fill(values_.begin(), values_.end(), 0.0); }

 private:
  static constexpr std::size_t kStride = static_cast<std::size_t>(N) * N;

  std::vector<int> starts_{0};
  std::vector<int> rows_;
  std::vector<double> values_;
};

}  // namespace wayfare
