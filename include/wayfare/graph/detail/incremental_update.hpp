#pragma once

// Update of the incremental solution.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include <wayfare/graph/detail/damped_step.hpp>
#include <wayfare/graph/incremental.hpp>
#include <wayfare/graph/optimise.hpp>

namespace wayfare {

template <class Graph>
Result<IncrementalReport> IncrementalGraphOptimiser<Graph>::update(
    const IncrementalOptions& options) {
  undetermined_ = {};
  if (auto checked = this->check_pending(); !checked) return checked.error();
  IncrementalReport report;
  moved_.clear();
  const auto solved = this->solved();
  admit();
  const double before = costs_.total();
  if (auto done = first_round(options, report); !done) return done.error();
  settle();
  find_deviation(report.reordered);
  further_rounds(options, report);
  find_costs();
  // Stale linearisation points and skipped small changes allow a slight increase.
  constexpr double kRise = 1e-2;
  if (!(costs_.total() <= (1.0 + kRise) * before + 1e-6)) fall_back(report);
  report.cost = costs_.total();
  if (!std::isfinite(report.cost)) return restore(solved);
  return report;
}

template <class Graph>
Result<void> IncrementalGraphOptimiser<Graph>::first_round(const IncrementalOptions& options,
                                                           IncrementalReport& report) {
  // What is not finite at old linearisation points may be so at the values.
  report.reordered = !finite_ || work_since_order_ > options.reorder_work * system_.total_flops();
  relinearised_.clear();
  if (report.reordered) {
    finite_ = true;
    relinearise_all();
    far_step_ = options.relinearise_step;  // from here on variables are listed by this one
    system_.touch_all();
    work_since_order_ = 0.0;
  } else {
    relinearise_far(options.relinearise_step);
  }
  linearise_again();
  if (const auto outcome = refactor(report); !outcome.ok) {
    const Error error = fault_of(outcome);
    undo_relinearisation();
    withdraw();
    return error;
  }
  return {};
}

/// √(cost / edges): less than one where the measurements are better than their information says. A
/// decrease would let all changes continue, as a reordering does.
template <class Graph>
void IncrementalGraphOptimiser<Graph>::find_deviation(bool may_decrease) {
  constexpr double kLeast = 1e-3;
  const double now = std::clamp(
      std::sqrt(costs_.total() / static_cast<double>(std::max<std::size_t>(1, costs_.size()))),
      kLeast, 1.0);
  deviation_ = may_decrease ? now : std::max(deviation_, now);
}

template <class Graph>
void IncrementalGraphOptimiser<Graph>::further_rounds(const IncrementalOptions& options,
                                                      IncrementalReport& report) {
  move_values(options, report);
  while (report.rounds < options.max_rounds && !far_.empty()) {
    relinearised_.clear();
    relinearise_far(options.relinearise_step);
    linearise_again();
    if (!refactor(report).ok) {
      undo_relinearisation();
      return;
    }
    move_values(options, report);
  }
}

template <class Graph>
FactorOutcome IncrementalGraphOptimiser<Graph>::refactor(IncrementalReport& report) {
  if (!finite_) return {.ok = false};
  const FactorOutcome outcome = system_.refactor();
  ++report.rounds;
  report.relinearised += static_cast<int>(relinearised_.size());
  report.refactored += system_.last_columns();
  report.flops += system_.last_flops();
  work_since_order_ += system_.last_flops();
  return outcome;
}

template <class Graph>
void IncrementalGraphOptimiser<Graph>::relinearise_far(double threshold) {
  if (!(threshold >= far_step_)) {  // the list may be incomplete
    far_.clear();
    for (std::size_t i = 0; i < admitted_variables_; ++i) {
      is_far_[i] = column_of_[i] >= 0 ? 1 : 0;
      if (is_far_[i] != 0) far_.push_back(static_cast<int>(i));
    }
  }
  far_step_ = threshold;
  for (const int variable : far_) {
    const auto step = system_.x(column_of_[index(variable)]);
    if (step.cwiseAbs().maxCoeff() > threshold) relinearise(variable);
    is_far_[index(variable)] = 0;
  }
  far_.clear();
}

template <class Graph>
void IncrementalGraphOptimiser<Graph>::relinearise_all() {
  for (const int variable : far_) is_far_[index(variable)] = 0;
  far_.clear();
  for (const int variable : variable_of_) relinearise(variable);
}

template <class Graph>
void IncrementalGraphOptimiser<Graph>::relinearise(int variable) {
  const int column = column_of_[index(variable)];
  relinearised_.push_back({variable, origins_[index(variable)], system_.x(column)});
  origins_[index(variable)] = this->value(variable);
  system_.reset(column, Step::Zero());
}

/// with(k) for each edge of the changed variables, once.
template <class Graph>
void IncrementalGraphOptimiser<Graph>::each_edge_of(const auto& changed, const auto& with) {
  ++stamp_;
  for (const auto& c : changed) {
    for (const int term : system_.terms_of(column_of_[index(c.variable)])) {
      const std::size_t k = this->edge_of(term);
      if (edge_mark_[k] == stamp_) continue;
      edge_mark_[k] = stamp_;
      with(k);
    }
  }
}

/// Relinearises the edges of the variables whose origin has moved.
template <class Graph>
void IncrementalGraphOptimiser<Graph>::linearise_again() {
  each_edge_of(relinearised_, [&](std::size_t k) {
    finite_ &= this->linearise(k, origins_, [&](int term, int, int, const auto& values) {
      system_.set_term(term, values);
    });
  });
}

/// After a refactorisation that failed.
template <class Graph>
void IncrementalGraphOptimiser<Graph>::undo_relinearisation() {
  for (const auto& r : relinearised_) {
    origins_[index(r.variable)] = r.before;
    system_.reset(column_of_[index(r.variable)], r.step);
  }
  linearise_again();
  finite_ = true;
  system_.roll_back(system_.variables(), system_.terms());
  far_step_ = std::numeric_limits<double>::infinity();  // all are checked next time
}

template <class Graph>
void IncrementalGraphOptimiser<Graph>::move_values(const IncrementalOptions& options,
                                                   IncrementalReport& report) {
  const bool by_deviation = options.solve_deviations > 0.0;
  const auto& changed =
      by_deviation ? system_.solve(options.solve_deviations * deviation_, ChangeUnit::deviation)
                   : system_.solve(options.solve_change);
  for (const int column : changed) {
    const int variable = variable_of_[index(column)];
    const Step step = system_.x(column);
    moved_.push_back({variable, this->value(variable)});
    this->place(variable, origins_[index(variable)], step);
    if (is_far_[index(variable)] != 0 || !(step.cwiseAbs().maxCoeff() > options.relinearise_step))
      continue;
    is_far_[index(variable)] = 1;
    far_.push_back(variable);
  }
  report.substituted += system_.last_solved();
}

/// Of the edges of all variables that moved in this update.
template <class Graph>
void IncrementalGraphOptimiser<Graph>::find_costs() {
  each_edge_of(moved_, [&](std::size_t k) { costs_.set(k, this->cost_of(k)); });
}

/// Batch optimisation from the values before the update; if that fails too, the update's result is
/// kept.
template <class Graph>
void IncrementalGraphOptimiser<Graph>::fall_back(IncrementalReport& report) {
  Graph start = graph_;
  for (std::size_t i = moved_.size(); i-- > 0;)
    Growing::set_value(start, moved_[i].variable, moved_[i].before);
  OptimiseOptions options;
  options.kernel = this->kernel();
  const auto done = GraphOptimiser<Graph>().optimise(start, options);
  if (done && !(costs_.total() <= done->final_cost) && take_values(start.values(), report))
    report.fell_back = true;
}

template <class Graph>
Result<OptimiseReport> IncrementalGraphOptimiser<Graph>::optimise_fully(OptimiseOptions options) {
  options.kernel = this->kernel();
  Graph solved = graph_;
  GraphOptimiser<Graph> batch;
  auto done = batch.optimise(solved, options);
  undetermined_ = batch.undetermined();
  if (!done) return done;
  IncrementalReport report;
  admit();
  if (auto taken = take_values(solved.values(), report); !taken) {
    withdraw();
    return taken.error();
  }
  settle();
  return done;
}

/// Sets the values and relinearises everything there.
template <class Graph>
Result<void> IncrementalGraphOptimiser<Graph>::take_values(const typename Graph::Values& values,
                                                           IncrementalReport& report) {
  const typename Graph::Values before = graph_.values();
  graph_.set_values(values);
  relinearised_.clear();
  relinearise_all();
  finite_ = true;
  linearise_again();
  system_.touch_all();
  if (const auto outcome = refactor(report); !outcome.ok) {
    const Error error = fault_of(outcome);
    graph_.set_values(before);
    undo_relinearisation();
    return error;
  }
  work_since_order_ = 0.0;
  // The remaining step at an optimum is below the stop criterion; the next update includes it.
  for (std::size_t k = 0; k < this->edges(); ++k) costs_.set(k, this->cost_of(k));
  return {};
}

template <class Graph>
Error IncrementalGraphOptimiser<Graph>::fault_of(const FactorOutcome& outcome) {
  undetermined_ = {};
  if (!finite_) return this->fault_at(origins_);
  if (outcome.block >= 0) {
    undetermined_.variable = variable_of_[index(outcome.block)];
    undetermined_.direction = Eigen::Map<const Step>(outcome.direction.data());
  }
  return undetermined_error(graph_, undetermined_);
}

/// Pending variables and edges become part of the system.
template <class Graph>
void IncrementalGraphOptimiser<Graph>::admit() {
  const auto size = static_cast<std::size_t>(graph_.size());
  for (std::size_t i = admitted_variables_; i < size; ++i) {
    const int variable = static_cast<int>(i);
    origins_.push_back(this->value(variable));
    column_of_.push_back(this->is_held(variable) ? -1 : system_.add_variable(graph_.dof(variable)));
    if (column_of_.back() >= 0) variable_of_.push_back(variable);
    is_far_.push_back(0);
  }
  costs_.resize(this->edges());
  edge_mark_.resize(this->edges(), 0);
  finite_ = true;
  const auto column = [&](int variable) { return variable < 0 ? -1 : column_of_[index(variable)]; };
  for (std::size_t k = admitted_edges_; k < this->edges(); ++k) {
    finite_ &= this->linearise(k, origins_, [&](int, int a, int b, const auto& values) {
      system_.add_term(column(a), column(b), values);
    });
    costs_.set(k, this->cost_of(k));
  }
}

/// Accepts the admitted variables and edges.
template <class Graph>
void IncrementalGraphOptimiser<Graph>::settle() {
  Growing::settle();
  admitted_variables_ = static_cast<std::size_t>(graph_.size());
  admitted_edges_ = this->edges();
}

/// Admitted variables and edges become pending again.
template <class Graph>
void IncrementalGraphOptimiser<Graph>::withdraw() {
  std::size_t free = variable_of_.size();
  while (free > 0 && index(variable_of_[free - 1]) >= admitted_variables_) --free;
  int terms = system_.terms();
  while (terms > 0 && this->edge_of(terms - 1) >= admitted_edges_) --terms;
  system_.roll_back(static_cast<int>(free), terms);
  variable_of_.resize(free);
  origins_.resize(admitted_variables_);
  column_of_.resize(admitted_variables_);
  is_far_.resize(admitted_variables_);
  edge_mark_.resize(admitted_edges_);
  costs_.resize(admitted_edges_);
}

/// Undoes an update that ended where errors are not finite; names one. The factor contains what is
/// pending again, so the next update admits everything.
template <class Graph>
Error IncrementalGraphOptimiser<Graph>::restore(const typename Growing::Solved& before) {
  Error error = cost_overflow(graph_);
  for (std::size_t i = moved_.size(); i-- > 0;)
    Growing::set_value(graph_, moved_[i].variable, moved_[i].before);
  this->unsettle(before);
  system_ = {};
  admitted_variables_ = admitted_edges_ = 0;
  variable_of_.clear();
  far_.clear();
  withdraw();
  far_step_ = std::numeric_limits<double>::infinity();
  return error;
}

// Compiled once in wayfare::graph.
extern template class GrowingGraph<PoseGraph<SE2d>>;
extern template class GrowingGraph<PoseGraph<SE3d>>;
extern template class IncrementalGraphOptimiser<PoseGraph<SE2d>>;
extern template class IncrementalGraphOptimiser<PoseGraph<SE3d>>;

}  // namespace wayfare
