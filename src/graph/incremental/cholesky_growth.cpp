// Changes of the system, and the part of the factor that they invalidate.

#include <algorithm>
#include <cstddef>
#include <utility>

#include <wayfare/graph/detail/incremental_cholesky.hpp>

namespace wayfare {

template <int N>
int IncrementalCholesky<N>::add_variable(int dof) {
  const int variable = variables();
  clique_of_.push_back(-1);
  dof_.push_back(dof);
  terms_of_.emplace_back();
  x_.resize(x_.size() + N, 0.0);
  for (auto* marks : {&variable_mark_, &reset_mark_, &changed_mark_, &place_, &slot_})
    marks->push_back(0);
  touched_.push_back(variable);
  structure_changed_ = true;
  return variable;
}

template <int N>
int IncrementalCholesky<N>::add_term(int a, int b, const Term& term) {
  const int added = terms();
  terms_.push_back(term);
  ends_.emplace_back(a, b);
  for (const int end : {a, b}) {
    if (end < 0) continue;
    terms_of_[index(end)].push_back(added);
    touched_.push_back(end);
  }
  structure_changed_ = true;
  return added;
}

template <int N>
void IncrementalCholesky<N>::set_term(int i, const Term& term) {
  terms_[index(i)] = term;
  for (const int end : {ends_[index(i)].first, ends_[index(i)].second})
    if (end >= 0) touched_.push_back(end);
}

template <int N>
void IncrementalCholesky<N>::reset(int variable, const Vector& x) {
  Eigen::Map<Vector>(x_.data() + offset(variable)) = x;
  reset_.push_back(variable);
}

template <int N>
void IncrementalCholesky<N>::roll_back(int variables_kept, int terms_kept) {
  while (terms() > terms_kept) {
    for (const int end : {ends_.back().first, ends_.back().second})
      if (end >= 0) terms_of_[index(end)].pop_back();
    ends_.pop_back();
    terms_.pop_back();
  }
  while (variables() > variables_kept) {
    clique_of_.pop_back();
    dof_.pop_back();
    terms_of_.pop_back();
    x_.resize(x_.size() - N);
    for (auto* marks : {&variable_mark_, &reset_mark_, &changed_mark_, &place_, &slot_})
      marks->pop_back();
  }
  forget_touched();
}

template <int N>
void IncrementalCholesky<N>::forget_touched() {
  touched_.clear();
  reset_.clear();
  all_touched_ = structure_changed_ = false;
}

template <int N>
FactorOutcome IncrementalCholesky<N>::refactor() {
  last_columns_ = 0;
  last_flops_ = 0.0;
  collect();
  if (affected_.empty()) return forget_touched(), FactorOutcome{};
  if (structure_changed_ || all_touched_)
    plan_in_new_order();
  else
    plan_as_before();
  const FactorOutcome outcome = factorise_fresh();
  if (outcome.ok) {
    commit();
  } else {
    for (const int clique : fresh_) release(clique);
    fresh_.clear();
  }
  return outcome;
}

/// marked_ = invalid cliques, affected_ = their frontals and the new variables, orphans_ = the
/// valid children of invalid cliques.
template <int N>
void IncrementalCholesky<N>::collect() {
  ++stamp_;
  marked_.clear();
  if (all_touched_) {
    for (int v = 0; v < variables(); ++v)
      if (clique_of_[index(v)] >= 0) mark_ancestors(clique_of_[index(v)]);
  } else {
    mark_involving();
    for (const int v : touched_)
      if (clique_of_[index(v)] >= 0) mark_ancestors(clique_of_[index(v)]);
  }
  collect_variables();
}

/// A variable that was reset invalidates all cliques that contain it: its own and the connected
/// ones below.
template <int N>
void IncrementalCholesky<N>::mark_involving() {
  for (const int v : reset_) reset_mark_[index(v)] = stamp_;
  stack_.clear();
  for (const int v : reset_)
    if (clique_of_[index(v)] >= 0) stack_.push_back(clique_of_[index(v)]);
  while (!stack_.empty()) {
    const int c = stack_.back();
    stack_.pop_back();
    if (expanded_[index(c)] == stamp_) continue;
    expanded_[index(c)] = stamp_;
    mark_ancestors(c);
    for (const int child : cliques_[index(c)].children) {
      const auto separator = cliques_[index(child)].separator();
      if (std::any_of(separator.begin(), separator.end(),
                      [&](int row) { return reset_mark_[index(row)] == stamp_; }))
        stack_.push_back(child);
    }
  }
}

template <int N>
void IncrementalCholesky<N>::mark_ancestors(int clique) {
  for (; clique >= 0 && clique_mark_[index(clique)] != stamp_;
       clique = cliques_[index(clique)].parent) {
    clique_mark_[index(clique)] = stamp_;
    marked_.push_back(clique);
  }
}

template <int N>
void IncrementalCholesky<N>::collect_variables() {
  affected_.clear();
  orphans_.clear();
  const auto take = [&](int v) {
    if (variable_mark_[index(v)] == stamp_) return;
    variable_mark_[index(v)] = stamp_;
    affected_.push_back(v);
  };
  for (const int c : marked_) {
    const Clique& clique = cliques_[index(c)];
    for (const int v : clique.eliminated()) take(v);
    for (const int child : clique.children)
      if (clique_mark_[index(child)] != stamp_) orphans_.push_back(child);
  }
  for (const int v : touched_)
    if (clique_of_[index(v)] < 0) take(v);
  std::sort(affected_.begin(), affected_.end());
}

template <int N>
int IncrementalCholesky<N>::acquire() {
  if (free_cliques_.empty()) {
    free_cliques_.push_back(static_cast<int>(cliques_.size()));
    cliques_.emplace_back();
    clique_mark_.push_back(0);
    expanded_.push_back(0);
  }
  const int clique = free_cliques_.back();
  free_cliques_.pop_back();
  return clique;
}

template <int N>
void IncrementalCholesky<N>::release(int c) {
  Clique& clique = cliques_[index(c)];
  clique.parent = -1;
  clique.frontals = 0;
  clique.fresh = clique.weak = false;
  clique.rows.clear();
  clique.probes.clear();
  clique.children.clear();
  // Cliques of all sizes reuse the memory: large buffers are freed, or each would grow to the
  // largest.
  constexpr std::size_t kKept = 512;
  if (clique.numbers.capacity() > kKept) std::vector<double>().swap(clique.numbers);
  if (clique.probes.capacity() > kKept) std::vector<double>().swap(clique.probes);
  free_cliques_.push_back(c);
}

template <int N>
void IncrementalCholesky<N>::commit() {
  const auto add_flops = [&](int c, double sign) {
    total_flops_ += sign * flops(cliques_[index(c)]);
  };
  for (const int c : marked_) add_flops(c, -1.0), release(c);
  for (const int c : fresh_) {
    add_flops(c, 1.0);
    const Clique& clique = cliques_[index(c)];
    for (const int v : clique.eliminated()) clique_of_[index(v)] = c;
    for (const int child : clique.children) cliques_[index(child)].parent = c;
  }
  last_columns_ = static_cast<int>(affected_.size());
  for (const int c : fresh_) {
    cliques_[index(c)].fresh = true;
    if (cliques_[index(c)].parent < 0) roots_.push_back(c);
  }
  forget_touched();
}

template class IncrementalCholesky<2>;
template class IncrementalCholesky<3>;
template class IncrementalCholesky<6>;

}  // namespace wayfare
