// Symbolic refactorisation of the invalid part of the factor: its order and cliques.

#include <algorithm>
#include <cstddef>

#include <wayfare/graph/detail/incremental_cholesky.hpp>

namespace wayfare {

/// Only values have changed: the invalid cliques are rebuilt with the same structure.
template <int N>
void IncrementalCholesky<N>::plan_as_before() {
  // Children before parents: a clique follows once all its children are done.
  for (const int c : marked_) cliques_[index(c)].pending = 0;
  for (const int c : marked_) {
    const int parent = cliques_[index(c)].parent;
    if (parent >= 0) ++cliques_[index(parent)].pending;
  }
  stack_.clear();
  for (const int c : marked_)
    if (cliques_[index(c)].pending == 0) stack_.push_back(c);
  int place = 0;
  fresh_.clear();
  // NOLINTNEXTLINE(modernize-loop-convert): parents are appended
  for (std::size_t next = 0; next < stack_.size(); ++next) {
    const int made = acquire();
    Clique& clique = cliques_[index(made)];
    Clique& before = cliques_[index(stack_[next])];
    before.made_anew = made;
    clique.rows = before.rows;
    clique.frontals = before.frontals;
    for (const int child : before.children) {
      const bool stays = clique_mark_[index(child)] != stamp_;
      clique.children.push_back(stays ? child : cliques_[index(child)].made_anew);
    }
    for (const int v : clique.eliminated()) place_[index(v)] = place++;
    fresh_.push_back(made);
    if (before.parent >= 0 && --cliques_[index(before.parent)].pending == 0)
      stack_.push_back(before.parent);
  }
}

template <int N>
void IncrementalCholesky<N>::plan_in_new_order() {
  const int nodes = static_cast<int>(affected_.size());
  for (int i = 0; i < nodes; ++i) place_[index(affected_[index(i)])] = i;
  order_.start(nodes);
  join_neighbours();
  constrained_ = affected_.back() == variables() - 1 ? nodes - 1 : nodes;
  if (constrained_ < nodes) order_.keep_last(constrained_);
  const std::vector<int>& order = order_.find();
  sequence_.clear();
  for (const int node : order) sequence_.push_back(affected_[index(node)]);
  for (int k = 0; k < nodes; ++k) place_[index(sequence_[index(k)])] = k;
  find_structures();
  make_cliques();
}

/// Couples the affected variables by their terms and by the updates from below.
template <int N>
void IncrementalCholesky<N>::join_neighbours() {
  for (const int v : affected_) {
    for (const int t : terms_of_[index(v)]) {
      const auto [a, b] = ends_[index(t)];
      // Each term once; terms with an unaffected variable are part of an orphan.
      if (a != v || b < 0 || a == b || variable_mark_[index(b)] != stamp_) continue;
      order_.join(place_[index(a)], place_[index(b)]);
    }
  }
  for (const int o : orphans_) {
    local_.clear();
    for (const int v : cliques_[index(o)].separator()) local_.push_back(place_[index(v)]);
    order_.join_all(local_);
  }
}

/// The structure of each column (later columns coupled to it), and the supernodes: a column absorbs
/// children where merging is cheaper.
template <int N>
void IncrementalCholesky<N>::find_structures() {
  const std::size_t n = sequence_.size();
  if (structures_.size() < n) structures_.resize(n);
  if (supernodes_.size() < n) supernodes_.resize(n);
  seen_.assign(n, -1);
  for (std::size_t k = 0; k < n; ++k) {
    Supernode& node = supernodes_[k];
    node.frontals.assign(1, static_cast<int>(k));
    node.children.clear();
    node.orphans.clear();
    node.merged = false;
  }
  for (const int o : orphans_) {
    int first = static_cast<int>(n);
    for (const int v : cliques_[index(o)].separator()) first = std::min(first, place_[index(v)]);
    supernodes_[index(first)].orphans.push_back(o);
  }
  for (std::size_t k = 0; k < n; ++k) {
    gather_structure(static_cast<int>(k));
    absorb_children(static_cast<int>(k));
    if (!structures_[k].empty())
      supernodes_[index(structures_[k].front())].children.push_back(static_cast<int>(k));
  }
}

template <int N>
void IncrementalCholesky<N>::gather_structure(int place) {
  auto& structure = structures_[index(place)];
  structure.clear();
  seen_[index(place)] = place;
  const auto take = [&](int later) {
    if (later < place || seen_[index(later)] == place) return;
    seen_[index(later)] = place;
    structure.push_back(later);
  };
  const int v = sequence_[index(place)];
  for (const int t : terms_of_[index(v)]) {
    const int other = ends_[index(t)].first == v ? ends_[index(t)].second : ends_[index(t)].first;
    if (other >= 0 && variable_mark_[index(other)] == stamp_) take(place_[index(other)]);
  }
  for (const int child : supernodes_[index(place)].children)
    for (const int later : structures_[index(child)]) take(later);
  for (const int o : supernodes_[index(place)].orphans)
    for (const int row : cliques_[index(o)].separator()) take(place_[index(row)]);
  std::sort(structure.begin(), structure.end());
}

namespace {

/// Blocks on and below the diagonal of `frontals` columns above `separators` more rows.
double column_blocks(double frontals, double separators) {
  return frontals * (0.5 * (frontals + 1.0) + separators);
}

/// Whether the additional zeros of eliminating a child with its parent cost less than an update
/// from one to the other.
bool worth_merging(double child, double child_separators, double parent, double separators) {
  const double together = column_blocks(child + parent, separators);
  const double zeros =
      together - column_blocks(child, child_separators) - column_blocks(parent, separators);
  const double columns = child + parent;
  return zeros <= (columns <= 4.0 ? 0.6 : columns <= 16.0 ? 0.2 : 0.05) * together;
}

}  // namespace

template <int N>
void IncrementalCholesky<N>::absorb_children(int place) {
  if (place >= constrained_) return;  // recent variables are not merged
  Supernode& node = supernodes_[index(place)];
  const auto separators = static_cast<double>(structures_[index(place)].size());
  std::vector<int>& kept = stack_;
  kept.clear();
  for (const int c : node.children) {
    Supernode& child = supernodes_[index(c)];
    const auto fits = worth_merging(static_cast<double>(child.frontals.size()),
                                    static_cast<double>(structures_[index(c)].size()),
                                    static_cast<double>(node.frontals.size()), separators);
    if (!fits) {
      kept.push_back(c);
      continue;
    }
    child.merged = true;
    node.frontals.insert(node.frontals.end() - 1, child.frontals.begin(), child.frontals.end());
    node.orphans.insert(node.orphans.end(), child.orphans.begin(), child.orphans.end());
    kept.insert(kept.end(), child.children.begin(), child.children.end());
  }
  node.children.assign(kept.begin(), kept.end());
}

template <int N>
void IncrementalCholesky<N>::make_cliques() {
  const std::size_t n = sequence_.size();
  clique_at_.assign(n, -1);
  fresh_.clear();
  for (std::size_t k = 0; k < n; ++k) {
    const Supernode& node = supernodes_[k];
    if (node.merged) continue;
    const int made = acquire();
    clique_at_[k] = made;
    Clique& clique = cliques_[index(made)];
    clique.frontals = static_cast<int>(node.frontals.size());
    for (const int place : node.frontals) clique.rows.push_back(sequence_[index(place)]);
    for (const int place : structures_[k]) clique.rows.push_back(sequence_[index(place)]);
    for (const int child : node.children) clique.children.push_back(clique_at_[index(child)]);
    clique.children.insert(clique.children.end(), node.orphans.begin(), node.orphans.end());
    fresh_.push_back(made);
  }
}

template class IncrementalCholesky<2>;
template class IncrementalCholesky<3>;
template class IncrementalCholesky<6>;

}  // namespace wayfare
