#include "graph/cholesky/supernodes.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "graph/cholesky/elimination_tree.hpp"

namespace wayfare::cholesky {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

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
