#include "graph/cholesky/symbolic.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace wayfare::cholesky {
namespace {

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

ColumnLists renumbered(const UpperPattern& pattern, std::span<const int> number) {
  return {at(pattern.columns()), [&](const auto& visit) {
            for (int c = 0; c < pattern.columns(); ++c) {
              const int b = number[at(c)];
              for (int k = pattern.starts[at(c)]; k + 1 < pattern.starts[at(c) + 1]; ++k) {
                const int a = number[at(pattern.rows[at(k)])];
                visit(std::max(a, b), std::min(a, b));
              }
            }
          }};
}

std::vector<int> elimination_tree(const ColumnLists& above) {
  std::vector<int> parent(above.count(), -1), ancestor(above.count(), -1);
  for (int j = 0; at(j) < above.count(); ++j) {
    for (int i : above[j]) {
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
std::vector<int> column_counts(const ColumnLists& above, std::span<const int> parent) {
  const std::size_t n = parent.size();
  std::vector<int> first(n, -1), count(n, 0), largest_first(n, -1), previous_leaf(n, -1);
  for (std::size_t j = 0; j < n; ++j) {
    if (first[j] < 0) count[j] = 1;  // a leaf of the elimination tree
    for (int i = static_cast<int>(j); i >= 0 && first[at(i)] < 0; i = parent[at(i)])
      first[at(i)] = static_cast<int>(j);
  }
  const ColumnLists below(n, [&](const auto& visit) {
    for (int c = 0; at(c) < n; ++c)
      for (const int r : above[c]) visit(r, c);
  });
  std::vector<int> ancestor(n);
  std::iota(ancestor.begin(), ancestor.end(), 0);
  for (std::size_t j = 0; j < n; ++j) {
    const int up = parent[j];
    if (up >= 0) --count[at(up)];  // j is not part of column `up`
    for (const int row : below[static_cast<int>(j)]) {
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

namespace {

constexpr int kTaken = -2;  // as parent: merged into another node

struct Node {
  int columns = 0, rows = 0;  // rows below the eliminated columns
  int parent = -1;
  int first = 0, own_columns = 0;  // before merging
  // Linked lists, from the latest entry: remaining children, and merged parts, whose columns come
  // before its own; `next` is the previous entry in the node's list.
  int child = -1, part = -1, next = -1;
};

class Merger {
 public:
  Merger(std::span<const int> parent, std::span<const int> counts, int block);
  Supernodes result();

 private:
  void merge_children(int s);
  void find_child_order();
  void append_columns(int s, std::vector<int>& order) const;

  void attach(int child, int parent) {
    nodes_[at(child)].next = nodes_[at(parent)].child;
    nodes_[at(parent)].child = child;
  }

  int block_;
  std::vector<Node> nodes_;
  std::vector<int> open_;
};

Merger::Merger(std::span<const int> parent, std::span<const int> counts, int block)
    : block_(block) {
  std::vector<int> of_column(parent.size());
  for (std::size_t j = 0; j < parent.size(); ++j) {
    const bool goes_on =
        j > 0 && parent[j - 1] == static_cast<int>(j) && counts[j - 1] == counts[j] + 1;
    if (!goes_on) {
      nodes_.emplace_back();
      nodes_.back().first = static_cast<int>(j);
    }
    of_column[j] = static_cast<int>(nodes_.size()) - 1;
    ++nodes_.back().columns;
    nodes_.back().rows = counts[j] - 1;
    nodes_.back().parent = parent[j];
  }
  for (std::size_t s = 0; s < nodes_.size(); ++s) {
    Node& node = nodes_[s];
    node.own_columns = node.columns;
    if (node.parent < 0) continue;
    node.parent = of_column[at(node.parent)];
    attach(static_cast<int>(s), node.parent);
  }
  for (std::size_t s = 0; s < nodes_.size(); ++s) merge_children(static_cast<int>(s));
}

void Merger::merge_children(int s) {
  Node& node = nodes_[at(s)];
  open_.clear();
  for (int c = node.child; c >= 0; c = nodes_[at(c)].next) open_.push_back(c);
  node.child = -1;
  double own = front_cost_ns(node.columns, node.rows, block_);
  while (!open_.empty()) {
    const int c = open_.back();
    open_.pop_back();
    Node& child = nodes_[at(c)];
    const double together = front_cost_ns(child.columns + node.columns, node.rows, block_);
    if (together > front_cost_ns(child.columns, child.rows, block_) + own) {
      attach(c, s);
      continue;
    }
    own = together;
    node.columns += child.columns;
    for (int i = child.child; i >= 0; i = nodes_[at(i)].next) open_.push_back(i);
    child.child = -1;
    child.parent = kTaken;
    child.next = node.part;
    node.part = c;
  }
}

// Latest first: a part may be a child of one merged before it, whose columns then come after.
void Merger::append_columns(int s, std::vector<int>& order) const {
  const Node& node = nodes_[at(s)];
  for (int part = node.part; part >= 0; part = nodes_[at(part)].next) append_columns(part, order);
  for (int k = 0; k < node.own_columns; ++k) order.push_back(node.first + k);
}

void Merger::find_child_order() {
  std::vector<double> peak(nodes_.size(), 0.0);
  const auto left = [&](int s) {
    return static_cast<double>(nodes_[at(s)].rows) * nodes_[at(s)].rows;
  };
  const auto needs_less = [&](int a, int b) {
    const double x = peak[at(a)] - left(a), y = peak[at(b)] - left(b);
    return x != y ? x < y : a > b;
  };
  for (std::size_t s = 0; s < nodes_.size(); ++s) {
    Node& node = nodes_[s];
    if (node.parent == kTaken) continue;
    open_.clear();
    for (int c = node.child; c >= 0; c = nodes_[at(c)].next) open_.push_back(c);
    std::sort(open_.begin(), open_.end(), needs_less);
    node.child = -1;
    for (const int c : open_) attach(c, static_cast<int>(s));
    double held = 0.0;
    for (int c = node.child; c >= 0; c = nodes_[at(c)].next) {
      peak[s] = std::max(peak[s], held + peak[at(c)]);
      held += left(c);
    }
    peak[s] = std::max(peak[s], held + left(static_cast<int>(s)));
  }
}

Supernodes Merger::result() {
  find_child_order();
  std::vector<int> place(nodes_.size(), -1);
  Supernodes result;
  const auto emit = [&](int s) {
    place[at(s)] = static_cast<int>(result.first.size());
    result.first.push_back(static_cast<int>(result.order.size()));
    append_columns(s, result.order);
    result.parent.push_back(-1);
    for (int c = nodes_[at(s)].child; c >= 0; c = nodes_[at(c)].next)
      result.parent[at(place[at(c)])] = place[at(s)];
  };
  std::vector<std::pair<int, int>> stack;  // a node and its next child to visit
  for (std::size_t root = 0; root < nodes_.size(); ++root) {
    if (nodes_[root].parent != -1) continue;
    stack.assign(1, {static_cast<int>(root), nodes_[root].child});
    while (!stack.empty()) {
      const auto [s, child] = stack.back();
      if (child >= 0) {
        stack.back().second = nodes_[at(child)].next;
        stack.emplace_back(child, nodes_[at(child)].child);
      } else {
        emit(s);
        stack.pop_back();
      }
    }
  }
  result.first.push_back(static_cast<int>(result.order.size()));
  return result;
}

}  // namespace

double front_cost_ns(int columns, int rows, int block) {
  constexpr double kFront = 100.0, kEntry = 0.5, kFlop = 1.0 / 12.0;
  const double p = static_cast<double>(columns) * block, m = static_cast<double>(rows) * block;
  return kFront + kEntry * (m * m + p * m) + kFlop * (p * p * p / 3.0 + p * p * m + p * m * m);
}

Supernodes find_supernodes(std::span<const int> parent, std::span<const int> counts, int block) {
  return Merger(parent, counts, block).result();
}

}  // namespace wayfare::cholesky
