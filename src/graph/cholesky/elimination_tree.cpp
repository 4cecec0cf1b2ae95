#include "graph/cholesky/elimination_tree.hpp"

#include <algorithm>
#include <cstddef>
#include <numeric>

namespace wayfare::cholesky {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// The root of i's current tree, with path compression.
int find_root(std::vector<int>& ancestor, int i) {
  int root = i;
  while (ancestor[at(root)] != root) root = ancestor[at(root)];
  while (i != root) {
    const int next = ancestor[at(i)];
    ancestor[at(i)] = root;
    i = next;
  }
  return root;
}

}  // namespace

RenumberedPattern::RenumberedPattern(const UpperPattern& pattern, std::span<const int> number)
    : starts_(at(pattern.columns()) + 1, 0) {
  const auto each = [&](const auto& visit) {
    for (int c = 0; c < pattern.columns(); ++c) {
      const int b = number[at(c)];
      for (int k = pattern.starts[at(c)]; k + 1 < pattern.starts[at(c) + 1]; ++k) {
        const int a = number[at(pattern.rows[at(k)])];
        visit(std::min(a, b), std::max(a, b));
      }
    }
  };
  each([&](int, int column) { ++starts_[at(column) + 1]; });
  std::partial_sum(starts_.begin(), starts_.end(), starts_.begin());
  rows_.resize(at(starts_.back()));
  std::vector<int> next(starts_.begin(), starts_.end() - 1);
  each([&](int row, int column) { rows_[at(next[at(column)]++)] = row; });
}

std::span<const int> RenumberedPattern::above(int column) const {
  return std::span(rows_).subspan(at(starts_[at(column)]),
                                  at(starts_[at(column) + 1] - starts_[at(column)]));
}

std::vector<int> elimination_tree(const RenumberedPattern& pattern) {
  std::vector<int> parent(at(pattern.columns()), -1), ancestor(at(pattern.columns()), -1);
  for (int j = 0; j < pattern.columns(); ++j) {
    for (int i : pattern.above(j)) {
      while (i != j) {  // to the root, with path compression to j
        const int next = ancestor[at(i)];
        ancestor[at(i)] = j;
        if (next < 0) parent[at(i)] = j;
        i = next < 0 ? j : next;
      }
    }
  }
  return parent;
}

std::vector<int> postorder(std::span<const int> parent) {
  const std::size_t n = parent.size();
  std::vector<int> child(n, -1), sibling(n, -1), order, stack;
  for (std::size_t i = n; i-- > 0;) {  // children ascending
    if (parent[i] < 0) continue;
    sibling[i] = child[at(parent[i])];
    child[at(parent[i])] = static_cast<int>(i);
  }
  order.reserve(n);
  for (std::size_t root = 0; root < n; ++root) {
    if (parent[root] >= 0) continue;
    stack.assign(1, static_cast<int>(root));
    while (!stack.empty()) {
      const int i = stack.back();
      if (const int c = child[at(i)]; c >= 0) {
        child[at(i)] = sibling[at(c)];
        stack.push_back(c);
      } else {
        order.push_back(i);
        stack.pop_back();
      }
    }
  }
  return order;
}

// Column j of L has as many blocks as there are row subtrees with j in them. The subtree of row i
// has its leaves among the columns of H's blocks in that row; with +1 at each leaf and −1 at the
// lowest common ancestors of consecutive leaves, the count of j is the sum over its subtree.
std::vector<int> column_counts(const RenumberedPattern& pattern, std::span<const int> parent) {
  const std::size_t n = parent.size();
  std::vector<int> first(n, -1), count(n, 0), largest_first(n, -1), previous_leaf(n, -1);
  for (std::size_t j = 0; j < n; ++j) {
    if (first[j] < 0) count[j] = 1;  // a leaf of the elimination tree
    for (int i = static_cast<int>(j); i >= 0 && first[at(i)] < 0; i = parent[at(i)])
      first[at(i)] = static_cast<int>(j);
  }
  // By columns: the rows of each column below the diagonal.
  std::vector<int> starts(n + 1, 0), below;
  for (std::size_t c = 0; c < n; ++c)
    for (const int r : pattern.above(static_cast<int>(c))) ++starts[at(r) + 1];
  std::partial_sum(starts.begin(), starts.end(), starts.begin());
  below.resize(at(starts[n]));
  std::vector<int> next(starts.begin(), starts.end() - 1), ancestor(n);
  for (std::size_t c = 0; c < n; ++c)
    for (const int r : pattern.above(static_cast<int>(c)))
      below[at(next[at(r)]++)] = static_cast<int>(c);
  std::iota(ancestor.begin(), ancestor.end(), 0);
  for (std::size_t j = 0; j < n; ++j) {
    const int up = parent[j];
    if (up >= 0) --count[at(up)];  // j is not part of column `up`
    for (int k = starts[j]; k < starts[j + 1]; ++k) {
      const int row = below[at(k)];
      if (first[j] <= largest_first[at(row)]) continue;  // not a leaf of the row's subtree
      largest_first[at(row)] = first[j];
      ++count[j];
      const int before = previous_leaf[at(row)];
      previous_leaf[at(row)] = static_cast<int>(j);
      if (before >= 0) --count[at(find_root(ancestor, before))];
    }
    if (up >= 0) ancestor[j] = up;
  }
  for (std::size_t j = 0; j < n; ++j)
    if (parent[j] >= 0) count[at(parent[j])] += count[j];
  return count;
}

std::vector<int> inverse_order(std::span<const int> order) {
  std::vector<int> inverse(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) inverse[at(order[k])] = static_cast<int>(k);
  return inverse;
}

}  // namespace wayfare::cholesky
