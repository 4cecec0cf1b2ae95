#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/contract.hpp>

namespace wayfare {

/// A symmetric matrix of N×N blocks. Stores the upper triangle column by column, rows ascending,
/// the diagonal block last in its column and always present. The pattern and the blocks' addresses
/// are constant after construction.
template <int N>
class BlockSparse {
 public:
  static constexpr int kBlock = N;
  using Block = Eigen::Matrix<double, N, N>;

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
