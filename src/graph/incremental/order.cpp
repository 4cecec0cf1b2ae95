#include <algorithm>
#include <cstddef>

#include <wayfare/graph/detail/incremental_order.hpp>

namespace wayfare {

void IncrementalOrder::start(int nodes) {
  nodes_ = remaining_ = nodes;
  extra_elements_ = 0;
  const auto n = static_cast<std::size_t>(nodes);
  if (neighbours_.size() < n) {
    neighbours_.resize(n);
    elements_of_.resize(n);
  }
  if (elements_.size() < n) elements_.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    neighbours_[i].clear();
    elements_of_[i].clear();
    elements_[i].clear();
  }
  is_last_.assign(n, 0);
  eliminated_.assign(n, 0);
  absorbed_.assign(n, 0);
  seen_.assign(n, 0);
  outside_.assign(n, 0);
  counted_.assign(n, 0);
  stamp_ = 0;
  order_.clear();
}

void IncrementalOrder::join(int a, int b) {
  at(neighbours_, a).push_back(b);
  at(neighbours_, b).push_back(a);
}

void IncrementalOrder::join_all(std::span<const int> nodes) {
  const int element = nodes_ + extra_elements_++;
  if (elements_.size() <= static_cast<std::size_t>(element)) elements_.emplace_back();
  at(elements_, element).assign(nodes.begin(), nodes.end());
  for (const int node : nodes) at(elements_of_, node).push_back(element);
  absorbed_.push_back(0);
  outside_.push_back(0);
  counted_.push_back(0);
}

const std::vector<int>& IncrementalOrder::find() {
  find_first_degrees();
  for (int pivot = take_least(); pivot >= 0; pivot = take_least()) {
    --remaining_;
    gather_pivot(pivot);
    // The remaining nodes are one clique, so their order does not matter.
    if (static_cast<int>(clique_.size()) == remaining_) break;
    count_outside();
    for (const int node : clique_) update_neighbour(node, pivot);
    at(elements_, pivot).swap(clique_);
  }
  append_rest();
  return order_;
}

void IncrementalOrder::find_first_degrees() {
  const auto n = static_cast<std::size_t>(nodes_);
  degree_.assign(n, 0);
  first_.assign(n + 1, -1);
  next_.assign(n, -1);
  previous_.assign(n, -1);
  least_ = nodes_;
  for (int node = nodes_ - 1; node >= 0; --node) {
    auto& joined = at(neighbours_, node);
    std::sort(joined.begin(), joined.end());
    joined.erase(std::unique(joined.begin(), joined.end()), joined.end());
    std::size_t degree = joined.size();
    for (const int e : at(elements_of_, node)) degree += at(elements_, e).size() - 1;
    at(degree_, node) = static_cast<int>(std::min(degree, n - 1));
    if (at(is_last_, node) == 0) list(node, at(degree_, node));
  }
}

void IncrementalOrder::list(int node, int degree) {
  at(degree_, node) = degree;
  const int head = at(first_, degree);
  at(next_, node) = head;
  at(previous_, node) = -1;
  if (head >= 0) at(previous_, head) = node;
  at(first_, degree) = node;
  least_ = std::min(least_, degree);
}

void IncrementalOrder::unlist(int node) {
  const int before = at(previous_, node), after = at(next_, node);
  if (after >= 0) at(previous_, after) = before;
  (before >= 0 ? at(next_, before) : at(first_, at(degree_, node))) = after;
}

/// −1 if only nodes of keep_last remain.
int IncrementalOrder::take_least() {
  while (least_ < nodes_ && at(first_, least_) < 0) ++least_;
  if (least_ >= nodes_) return -1;
  const int node = at(first_, least_);
  unlist(node);
  at(eliminated_, node) = 1;
  order_.push_back(node);
  return node;
}

/// clique_ = all nodes adjacent to `pivot`, directly or through an element; those elements are
/// absorbed.
void IncrementalOrder::gather_pivot(int pivot) {
  clique_.clear();
  ++stamp_;
  const auto gather = [&](const std::vector<int>& nodes) {
    for (const int node : nodes) {
      if (at(eliminated_, node) != 0 || at(seen_, node) == stamp_) continue;
      at(seen_, node) = stamp_;
      clique_.push_back(node);
    }
  };
  gather(at(neighbours_, pivot));
  for (const int e : at(elements_of_, pivot)) {
    if (at(absorbed_, e) != 0) continue;
    gather(at(elements_, e));
    at(absorbed_, e) = 1;
  }
}

/// For each element that shares a node with the clique: the number of its nodes outside.
void IncrementalOrder::count_outside() {
  for (const int node : clique_) {
    for (const int e : at(elements_of_, node)) {
      if (at(absorbed_, e) != 0) continue;
      if (at(counted_, e) != stamp_) {
        at(counted_, e) = stamp_;
        at(outside_, e) = static_cast<int>(at(elements_, e).size());
      }
      --at(outside_, e);
    }
  }
}

void IncrementalOrder::update_neighbour(int node, int pivot) {
  const int others = static_cast<int>(clique_.size()) - 1;
  int outside = 0;
  auto& elements = at(elements_of_, node);
  std::erase_if(elements, [&](int e) {
    if (at(absorbed_, e) != 0 || at(outside_, e) == 0) return true;  // inside the pivot's element
    outside += at(outside_, e);
    return false;
  });
  elements.push_back(pivot);
  auto& joined = at(neighbours_, node);
  std::erase_if(joined, [&](int n) { return at(eliminated_, n) != 0 || at(seen_, n) == stamp_; });
  if (at(is_last_, node) != 0) return;
  const int degree = std::min({remaining_ - 1, at(degree_, node) + others,
                               static_cast<int>(joined.size()) + others + outside});
  unlist(node);
  list(node, degree);
}

void IncrementalOrder::append_rest() {
  for (const int last : {0, 1})
    for (int node = 0; node < nodes_; ++node)
      if (at(eliminated_, node) == 0 && at(is_last_, node) == last) order_.push_back(node);
}

}  // namespace wayfare
