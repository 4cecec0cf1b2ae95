#include "graph/cholesky/symbolic.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <utility>

namespace wayfare::cholesky {
namespace {

/// Nodes of the quotient graph are variables (columns not yet eliminated; indistinguishable ones
/// are merged into one) and elements (cliques left by eliminations). A variable's list has its
/// elements, then the variables adjacent to it; an element's list has its variables.
class QuotientGraph {
 public:
  explicit QuotientGraph(const UpperPattern& pattern);
  std::vector<int> eliminate_all();

 private:
  enum class State : char { variable, element, gone };
  struct Node {
    int begin = 0, length = 0;
    int elements = 0;  // of a variable: number of elements at the start of its list
    int weight = 1;    // merged columns; negative in the current element; 0 if merged
    int degree = 0;
    int next = -1, previous = -1;  // in the list of its degree
    State state = State::variable;
  };

  void set_dense_aside(const std::vector<int>& degrees);
  void fill_lists(const UpperPattern& pattern);
  void link(int v);
  void unlink(int v);
  int take_minimum();
  void form_element(int p);
  void take_into_element(int v);
  void count_outside();
  void update_variable(int v, int p);
  void merge_alike();
  [[nodiscard]] bool alike(int a, int b) const;
  void merge(int into, int v);
  void finish_element(int p);

  [[nodiscard]] Node& node(int i) { return nodes_[at(i)]; }
  [[nodiscard]] const Node& node(int i) const { return nodes_[at(i)]; }

  std::vector<Node> nodes_;
  std::vector<int> list_;
  std::vector<int> with_degree_;    // first variable of each degree
  std::vector<int> member_, last_;  // merged columns, as a chain
  std::vector<std::int64_t> mark_;  // of elements: stamp_ + weight outside the current one
  std::vector<std::int64_t> seen_;  // of the list that others are compared with
  std::vector<std::pair<unsigned, int>> hashed_;
  std::vector<int> order_, dense_;
  std::int64_t stamp_ = 1, seen_stamp_ = 0;
  int minimum_ = 0, remaining_ = 0;
  int element_begin_ = 0, element_weight_ = 0;
};

QuotientGraph::QuotientGraph(const UpperPattern& pattern)
    : nodes_(at(pattern.columns())),
      with_degree_(nodes_.size() + 1, -1),
      member_(nodes_.size(), -1),
      last_(nodes_.size()),
      mark_(nodes_.size(), 0),
      seen_(nodes_.size(), 0) {
  std::vector<int> degrees(nodes_.size(), 0);
  for (int c = 0; c < pattern.columns(); ++c) {
    last_[at(c)] = c;
    for (int b = pattern.starts[at(c)]; b + 1 < pattern.starts[at(c) + 1]; ++b) {
      ++degrees[at(c)];
      ++degrees[at(pattern.rows[at(b)])];
    }
  }
  set_dense_aside(degrees);
  int begin = 0;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    nodes_[i].begin = begin;
    begin += degrees[i];
  }
  list_.reserve(at(begin) * 2);
  list_.resize(at(begin));
  fill_lists(pattern);
  for (int i = 0; i < pattern.columns(); ++i) {
    if (node(i).weight == 0) continue;
    node(i).degree = node(i).length;
    link(i);
  }
}

// A column adjacent to nearly all others would be updated in nearly every elimination.
void QuotientGraph::set_dense_aside(const std::vector<int>& degrees) {
  const int limit =
      std::max(16, static_cast<int>(10.0 * std::sqrt(static_cast<double>(degrees.size()))));
  for (std::size_t i = 0; i < degrees.size(); ++i) {
    if (degrees[i] > limit) {
      dense_.push_back(static_cast<int>(i));
      nodes_[i].weight = 0;
      nodes_[i].state = State::gone;
    } else {
      ++remaining_;
    }
  }
  std::stable_sort(dense_.begin(), dense_.end(),
                   [&](int a, int b) { return degrees[at(a)] < degrees[at(b)]; });
}

void QuotientGraph::fill_lists(const UpperPattern& pattern) {
  for (int c = 0; c < pattern.columns(); ++c) {
    Node& column = node(c);
    if (column.weight == 0) continue;
    for (int b = pattern.starts[at(c)]; b + 1 < pattern.starts[at(c) + 1]; ++b) {
      const int r = pattern.rows[at(b)];
      Node& row = node(r);
      if (row.weight == 0) continue;
      list_[at(column.begin + column.length++)] = r;
      list_[at(row.begin + row.length++)] = c;
    }
  }
}

void QuotientGraph::link(int v) {
  Node& n = node(v);
  int& first = with_degree_[at(n.degree)];
  n.previous = -1;
  n.next = first;
  if (first >= 0) node(first).previous = v;
  first = v;
  minimum_ = std::min(minimum_, n.degree);
}

void QuotientGraph::unlink(int v) {
  const Node& n = node(v);
  if (n.next >= 0) node(n.next).previous = n.previous;
  (n.previous >= 0 ? node(n.previous).next : with_degree_[at(n.degree)]) = n.next;
}

int QuotientGraph::take_minimum() {
  while (with_degree_[at(minimum_)] < 0) ++minimum_;
  const int p = with_degree_[at(minimum_)];
  unlink(p);
  return p;
}

void QuotientGraph::take_into_element(int v) {
  Node& n = node(v);
  if (n.weight <= 0) return;
  unlink(v);
  element_weight_ += n.weight;
  n.weight = -n.weight;
  list_.push_back(v);
}

/// The variables that become a clique when p is eliminated: those of p and of its elements.
void QuotientGraph::form_element(int p) {
  remaining_ -= node(p).weight;
  node(p).weight = -node(p).weight;
  element_begin_ = static_cast<int>(list_.size());
  element_weight_ = 0;
  const auto [begin, length, elements] =
      std::tuple(node(p).begin, node(p).length, node(p).elements);
  for (int k = 0; k < elements; ++k) {
    Node& e = node(list_[at(begin + k)]);
    if (e.state != State::element) continue;
    for (int i = 0; i < e.length; ++i) take_into_element(list_[at(e.begin + i)]);
    e.state = State::gone;
  }
  for (int k = elements; k < length; ++k) take_into_element(list_[at(begin + k)]);
  node(p).begin = element_begin_;
  node(p).length = static_cast<int>(list_.size()) - element_begin_;
  node(p).state = State::element;
}

/// mark_[e] − stamp_ = the weight of element e outside the current one.
void QuotientGraph::count_outside() {
  for (std::size_t k = at(element_begin_); k < list_.size(); ++k) {
    const Node& v = node(list_[k]);
    for (int i = 0; i < v.elements; ++i) {
      const int e = list_[at(v.begin + i)];
      if (node(e).state != State::element) continue;
      if (mark_[at(e)] < stamp_) mark_[at(e)] = stamp_ + node(e).degree;
      mark_[at(e)] += v.weight;  // negative here
    }
  }
}

void QuotientGraph::update_variable(int v, int p) {
  Node& n = node(v);
  unsigned hash = 0;
  int degree = 0, out = n.begin;
  for (int i = n.begin; i < n.begin + n.elements; ++i) {
    const int e = list_[at(i)];
    if (node(e).state != State::element) continue;
    const int outside = static_cast<int>(mark_[at(e)] - stamp_);
    if (outside == 0) {  // a part of the new element
      node(e).state = State::gone;
      continue;
    }
    degree += outside;
    hash += static_cast<unsigned>(e);
    list_[at(out++)] = e;
  }
  const int elements = out - n.begin;
  for (int i = n.begin + n.elements; i < n.begin + n.length; ++i) {
    const int u = list_[at(i)];
    if (node(u).weight <= 0) continue;
    degree += node(u).weight;
    hash += static_cast<unsigned>(u);
    list_[at(out++)] = u;
  }
  if (degree == 0) {  // adjacent to nothing else: eliminated with the pivot
    element_weight_ += n.weight;
    remaining_ += n.weight;
    merge(p, v);
    return;
  }
  // There is room for one more entry: v's link to the pivot was just removed.
  list_[at(out)] = list_[at(n.begin + elements)];
  list_[at(n.begin + elements)] = list_[at(n.begin)];
  list_[at(n.begin)] = p;
  n.elements = elements + 1;
  n.length = out + 1 - n.begin;
  n.degree = std::min(n.degree, degree);
  hashed_.emplace_back(hash, v);
}

void QuotientGraph::merge(int into, int v) {
  member_[at(last_[at(into)])] = v;
  last_[at(into)] = last_[at(v)];
  node(into).weight += node(v).weight;
  node(v).weight = 0;
  node(v).state = State::gone;
}

bool QuotientGraph::alike(int a, int b) const {
  const Node &x = node(a), &y = node(b);
  if (x.length != y.length || x.elements != y.elements) return false;
  for (int i = 0; i < y.length; ++i)
    if (seen_[at(list_[at(y.begin + i)])] != seen_stamp_) return false;
  return true;
}

void QuotientGraph::merge_alike() {
  std::sort(hashed_.begin(), hashed_.end());
  for (std::size_t i = 0; i < hashed_.size(); ++i) {
    const auto [hash, v] = hashed_[i];
    if (i + 1 == hashed_.size() || hashed_[i + 1].first != hash || node(v).weight == 0) continue;
    ++seen_stamp_;
    const Node& n = node(v);
    for (int k = 0; k < n.length; ++k) seen_[at(list_[at(n.begin + k)])] = seen_stamp_;
    for (std::size_t j = i + 1; j < hashed_.size() && hashed_[j].first == hash; ++j) {
      const int other = hashed_[j].second;
      if (node(other).weight != 0 && alike(v, other)) merge(v, other);
    }
  }
  hashed_.clear();
}

void QuotientGraph::finish_element(int p) {
  std::size_t out = at(element_begin_);
  for (std::size_t k = out; k < list_.size(); ++k) {
    const int v = list_[k];
    Node& n = node(v);
    if (n.weight == 0) continue;
    n.weight = -n.weight;
    n.degree = std::min(n.degree + element_weight_, remaining_) - n.weight;
    link(v);
    list_[out++] = v;
  }
  list_.resize(out);
  node(p).length = static_cast<int>(out) - element_begin_;
  node(p).degree = element_weight_;
  if (node(p).length == 0) node(p).state = State::gone;
}

std::vector<int> QuotientGraph::eliminate_all() {
  order_.reserve(nodes_.size());
  while (order_.size() + dense_.size() < nodes_.size()) {
    const int p = take_minimum();
    form_element(p);
    count_outside();
    const std::size_t end = list_.size();
    for (std::size_t k = at(element_begin_); k < end; ++k) update_variable(list_[k], p);
    stamp_ += static_cast<std::int64_t>(nodes_.size()) + 1;
    merge_alike();
    finish_element(p);
    for (int c = p; c >= 0; c = member_[at(c)]) order_.push_back(c);
  }
  order_.insert(order_.end(), dense_.begin(), dense_.end());
  return std::move(order_);
}

}  // namespace

std::vector<int> minimum_degree(const UpperPattern& pattern) {
  return QuotientGraph(pattern).eliminate_all();
}

}  // namespace wayfare::cholesky
