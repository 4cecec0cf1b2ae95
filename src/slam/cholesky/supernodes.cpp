#include "cholesky/supernodes.hpp"

#include <algorithm>
#include <cstddef>

#include "cholesky/elimination_tree.hpp"

namespace wayfare::cholesky {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

struct Node {
  int columns = 0, rows = 0;  // rows below the eliminated columns
  int parent = -1;
  std::vector<int> parts;  // others taken into this, their columns before its own
};

/// Nanoseconds a front takes, about: to set up, to write its update and add it to the parent's, and
/// to compute.
double cost(int columns, int rows, int block) {
  constexpr double kFront = 100.0, kEntry = 0.5, kFlop = 1.0 / 12.0;
  const double p = static_cast<double>(columns) * block, m = static_cast<double>(rows) * block;
  return kFront + kEntry * (m * m + p * m) + kFlop * (p * p * p / 3.0 + p * p * m + p * m * m);
}

class Merger {
 public:
  Merger(std::span<const int> parent, std::span<const int> counts, int block);
  Supernodes result();

 private:
  void merge_children(int s);
  void find_child_order();
  void append_columns(int s, std::vector<int>& order) const;

  int block_;
  std::vector<Node> nodes_;
  std::vector<int> own_first_, own_columns_;  // before merging
  std::vector<std::vector<int>> children_;
};

Merger::Merger(std::span<const int> parent, std::span<const int> counts, int block)
    : block_(block) {
  std::vector<int> of_column(parent.size());
  for (std::size_t j = 0; j < parent.size(); ++j) {
    const bool goes_on =
        j > 0 && parent[j - 1] == static_cast<int>(j) && counts[j - 1] == counts[j] + 1;
    if (!goes_on) {
      nodes_.emplace_back();
      own_first_.push_back(static_cast<int>(j));
    }
    of_column[j] = static_cast<int>(nodes_.size()) - 1;
    ++nodes_.back().columns;
    nodes_.back().rows = counts[j] - 1;
    nodes_.back().parent = parent[j];
  }
  children_.resize(nodes_.size());
  for (std::size_t s = 0; s < nodes_.size(); ++s) {
    Node& node = nodes_[s];
    own_columns_.push_back(node.columns);
    if (node.parent < 0) continue;
    node.parent = of_column[at(node.parent)];
    children_[at(node.parent)].push_back(static_cast<int>(s));
  }
  for (std::size_t s = 0; s < nodes_.size(); ++s) merge_children(static_cast<int>(s));
}

void Merger::merge_children(int s) {
  Node& node = nodes_[at(s)];
  std::vector<int> kept, open = std::move(children_[at(s)]);
  while (!open.empty()) {
    const int c = open.back();
    open.pop_back();
    const Node& child = nodes_[at(c)];
    const double apart =
        cost(child.columns, child.rows, block_) + cost(node.columns, node.rows, block_);
    if (cost(child.columns + node.columns, node.rows, block_) > apart) {
      kept.push_back(c);
      continue;
    }
    node.columns += child.columns;
    node.parts.push_back(c);
    open.insert(open.end(), children_[at(c)].begin(), children_[at(c)].end());
    children_[at(c)].clear();
  }
  children_[at(s)] = std::move(kept);
}

void Merger::append_columns(int s, std::vector<int>& order) const {
  // The parts of a part come before it; a part taken in later may be a child of an earlier one.
  const Node& node = nodes_[at(s)];
  for (auto part = node.parts.rbegin(); part != node.parts.rend(); ++part)
    append_columns(*part, order);
  for (int k = 0; k < own_columns_[at(s)]; ++k) order.push_back(own_first_[at(s)] + k);
}

void Merger::find_child_order() {
  std::vector<double> peak(nodes_.size(), 0.0);
  const auto left = [&](int s) {
    return static_cast<double>(nodes_[at(s)].rows) * nodes_[at(s)].rows;
  };
  for (std::size_t s = 0; s < nodes_.size(); ++s) {
    auto& children = children_[s];
    std::sort(children.begin(), children.end(), [&](int a, int b) {
      const double x = peak[at(a)] - left(a), y = peak[at(b)] - left(b);
      return x != y ? x > y : a < b;
    });
    double held = 0.0;
    for (const int c : children) {
      peak[s] = std::max(peak[s], held + peak[at(c)]);
      held += left(c);
    }
    peak[s] = std::max(peak[s], held + left(static_cast<int>(s)));
  }
}

Supernodes Merger::result() {
  find_child_order();
  std::vector<char> taken(nodes_.size(), 0);
  for (const Node& node : nodes_)
    for (const int part : node.parts) taken[at(part)] = 1;
  std::vector<int> place(nodes_.size(), -1), parent_of(nodes_.size(), -1);
  Supernodes result;
  std::vector<std::pair<int, std::size_t>> stack;
  const auto emit = [&](int s) {
    place[at(s)] = static_cast<int>(result.first.size());
    result.first.push_back(static_cast<int>(result.order.size()));
    append_columns(s, result.order);
    result.parent.push_back(parent_of[at(s)]);
  };
  for (std::size_t root = 0; root < nodes_.size(); ++root) {
    if (taken[root] || nodes_[root].parent >= 0) continue;
    stack.assign(1, {static_cast<int>(root), 0});
    while (!stack.empty()) {
      auto& [s, next] = stack.back();
      if (next < children_[at(s)].size()) {
        const int c = children_[at(s)][next++];
        parent_of[at(c)] = s;
        stack.emplace_back(c, 0);
      } else {
        emit(s);
        stack.pop_back();
      }
    }
  }
  for (int& p : result.parent)
    if (p >= 0) p = place[at(p)];
  result.first.push_back(static_cast<int>(result.order.size()));
  return result;
}

}  // namespace

Supernodes find_supernodes(std::span<const int> parent, std::span<const int> counts, int block) {
  return Merger(parent, counts, block).result();
}

}  // namespace wayfare::cholesky
