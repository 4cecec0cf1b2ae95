#pragma once

#include <cstddef>
#include <vector>

namespace wayfare {

/// A sum of many values of which a few change: a binary tree of partial sums, so that a change
/// costs O(log n) and replaced values leave no rounding errors.
class IncrementalSum {
 public:
  /// Values from `size` on are removed, new ones are zero.
  void resize(std::size_t size) {
    for (std::size_t i = size; i < size_; ++i) set(i, 0.0);
    std::size_t width = tree_.size() / 2;
    while (width < size) width *= 2;
    if (tree_.size() < 2 * width) widen(width);
    size_ = size;
  }
  [[nodiscard]] std::size_t size() const { return size_; }

  void set(std::size_t i, double value) {
    const std::size_t leaf = tree_.size() / 2 + i;
    tree_[leaf] = value;
    if (leaf > 1) touch(leaf / 2);
  }
  [[nodiscard]] double operator[](std::size_t i) const { return tree_[tree_.size() / 2 + i]; }

  /// Updates the partial sums that have changed since the last call.
  [[nodiscard]] double total() {
    // Parents are appended after all nodes of the level below: level by level up to the root.
    // NOLINTNEXTLINE(modernize-loop-convert): touch() appends to stale_
    for (std::size_t next = 0; next < stale_.size(); ++next) {
      const std::size_t node = stale_[next];
      is_stale_[node] = 0;
      tree_[node] = tree_[2 * node] + tree_[2 * node + 1];
      if (node > 1) touch(node / 2);
    }
    stale_.clear();
    return tree_[1];
  }

 private:
  void touch(std::size_t node) {
    if (is_stale_[node] != 0) return;
    is_stale_[node] = 1;
    stale_.push_back(node);
  }
  /// `width` leaves, a power of two.
  void widen(std::size_t width) {
    std::vector<double> tree(2 * width, 0.0);
    for (std::size_t i = 0; i < size_; ++i) tree[width + i] = (*this)[i];
    tree_.swap(tree);
    is_stale_.assign(width, 0);
    stale_.clear();
    for (std::size_t i = 0; i < size_; ++i) set(i, tree_[width + i]);
  }

  std::size_t size_ = 0;
  std::vector<double> tree_ = std::vector<double>(2, 0.0);  // node 1 is the root
  std::vector<char> is_stale_ = std::vector<char>(1, 0);    // of the nodes that are sums
  std::vector<std::size_t> stale_;
};

}  // namespace wayfare
