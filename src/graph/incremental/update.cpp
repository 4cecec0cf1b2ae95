// Update of the incremental solution.

#include <cmath>
#include <limits>

#include <wayfare/graph/detail/normal_equations.hpp>
#include <wayfare/graph/incremental.hpp>
#include <wayfare/graph/optimise.hpp>

namespace wayfare {

template <LieGroup G>
Result<IncrementalReport> IncrementalOptimiser<G>::update(const IncrementalOptions& options) {
  undetermined_ = {};
  if (auto checked = check_pending(); !checked) return checked.error();
  IncrementalReport report;
  moved_.clear();
  admit();
  const double before = costs_.total();
  if (auto done = first_round(options, report); !done) return done.error();
  settle();
  further_rounds(options, report);
  // Stale linearisation points and skipped small changes allow a slight increase.
  constexpr double kRise = 1e-2;
  if (!(costs_.total() <= (1.0 + kRise) * before + 1e-6)) fall_back(report);
  report.cost = costs_.total();
  return report;
}

template <LieGroup G>
Result<void> IncrementalOptimiser<G>::first_round(const IncrementalOptions& options,
                                                  IncrementalReport& report) {
  report.reordered = work_since_order_ > options.reorder_work * system_.total_flops();
  relinearised_.clear();
  if (report.reordered) {
    relinearise_all();
    far_step_ = options.relinearise_step;  // from here on poses are listed by this one
    system_.touch_all();
    work_since_order_ = 0.0;
  } else {
    relinearise_far(options.relinearise_step);
  }
  linearise_again();
  if (const auto outcome = refactor(report); !outcome.ok) {
    const Error error = name_undetermined(outcome);
    undo_relinearisation();
    withdraw();
    return error;
  }
  move_poses(options, report);
  return {};
}

template <LieGroup G>
void IncrementalOptimiser<G>::further_rounds(const IncrementalOptions& options,
                                             IncrementalReport& report) {
  while (report.rounds < options.max_rounds && !far_.empty()) {
    relinearised_.clear();
    relinearise_far(options.relinearise_step);
    linearise_again();
    if (!refactor(report).ok) {
      undo_relinearisation();
      return;
    }
    move_poses(options, report);
  }
}

template <LieGroup G>
FactorOutcome IncrementalOptimiser<G>::refactor(IncrementalReport& report) {
  const FactorOutcome outcome = system_.refactor();
  ++report.rounds;
  report.relinearised += static_cast<int>(relinearised_.size());
  report.refactored += system_.last_columns();
  report.flops += system_.last_flops();
  work_since_order_ += system_.last_flops();
  return outcome;
}

template <LieGroup G>
void IncrementalOptimiser<G>::relinearise_far(double threshold) {
  if (!(threshold >= far_step_)) {  // the list may be incomplete
    far_.clear();
    for (std::size_t i = 0; i < solved_poses_; ++i) {
      is_far_[i] = variable_of_[i] >= 0;
      if (is_far_[i] != 0) far_.push_back(static_cast<int>(i));
    }
  }
  far_step_ = threshold;
  std::erase_if(far_, [&](int pose) {
    const auto step = system_.x(variable_of_[index(pose)]);
    if (step.cwiseAbs().maxCoeff() > threshold) relinearise(pose);
    is_far_[index(pose)] = 0;
    return true;
  });
}

template <LieGroup G>
void IncrementalOptimiser<G>::relinearise_all() {
  for (const int pose : far_) is_far_[index(pose)] = 0;
  far_.clear();
  for (const int pose : pose_of_) relinearise(pose);
}

template <LieGroup G>
void IncrementalOptimiser<G>::relinearise(int pose) {
  const int variable = variable_of_[index(pose)];
  relinearised_.push_back({pose, origins_[index(pose)], system_.x(variable)});
  origins_[index(pose)] = graph_.poses[index(pose)];
  system_.reset(variable, TangentOf<G>::Zero());
}

/// Relinearises the edges of the poses whose origin has moved.
template <LieGroup G>
void IncrementalOptimiser<G>::linearise_again() {
  ++stamp_;
  for (const auto& r : relinearised_) {
    for (const int k : system_.terms_of(variable_of_[index(r.pose)])) {
      if (edge_mark_[index(k)] == stamp_) continue;
      edge_mark_[index(k)] = stamp_;
      system_.set_term(k, linearise(graph_.edges[index(k)]));
    }
  }
}

/// After a refactorisation that failed.
template <LieGroup G>
void IncrementalOptimiser<G>::undo_relinearisation() {
  for (const auto& r : relinearised_) {
    origins_[index(r.pose)] = r.before;
    system_.reset(variable_of_[index(r.pose)], r.step);
  }
  linearise_again();
  system_.roll_back(system_.variables(), system_.terms());
  far_step_ = std::numeric_limits<double>::infinity();  // all are checked next time
}

template <LieGroup G>
void IncrementalOptimiser<G>::move_poses(const IncrementalOptions& options,
                                         IncrementalReport& report) {
  const std::size_t first = moved_.size();
  for (const int variable : system_.solve(options.solve_change)) {
    const int pose = pose_of_[index(variable)];
    const TangentOf<G> step = system_.x(variable);
    moved_.push_back({pose, graph_.poses[index(pose)]});
    graph_.poses[index(pose)] = ManifoldTraits<G>::plus(origins_[index(pose)], step);
    if (is_far_[index(pose)] != 0 || !(step.cwiseAbs().maxCoeff() > options.relinearise_step))
      continue;
    is_far_[index(pose)] = 1;
    far_.push_back(pose);
  }
  report.substituted += system_.last_solved();
  sum_costs(first);
}

template <LieGroup G>
void IncrementalOptimiser<G>::sum_costs(std::size_t first_moved) {
  ++stamp_;
  for (std::size_t i = first_moved; i < moved_.size(); ++i) {
    for (const int k : system_.terms_of(variable_of_[index(moved_[i].pose)])) {
      if (edge_mark_[index(k)] == stamp_) continue;
      edge_mark_[index(k)] = stamp_;
      costs_.set(index(k), robust_cost(graph_, graph_.edges[index(k)], kernel_));
    }
  }
}

/// Batch optimisation from the poses before the update; if that fails too, the update's result is
/// kept.
template <LieGroup G>
void IncrementalOptimiser<G>::fall_back(IncrementalReport& report) {
  PoseGraph<G> start = graph_;
  for (std::size_t i = moved_.size(); i-- > 0;)
    start.poses[index(moved_[i].pose)] = moved_[i].before;
  OptimiseOptions options;
  options.kernel = kernel_;
  const auto done = PoseGraphOptimiser<G>().optimise(start, options);
  if (done && done->final_cost < costs_.total() && take_poses(start.poses, report))
    report.fell_back = true;
}

template <LieGroup G>
Result<OptimiseReport> IncrementalOptimiser<G>::optimise_fully(OptimiseOptions options) {
  options.kernel = kernel_;
  PoseGraph<G> solved = graph_;
  PoseGraphOptimiser<G> batch;
  auto done = batch.optimise(solved, options);
  undetermined_ = batch.undetermined();
  if (!done) return done;
  IncrementalReport report;
  admit();
  if (auto taken = take_poses(solved.poses, report); !taken) {
    withdraw();
    return taken.error();
  }
  settle();
  return done;
}

/// Sets the poses and relinearises everything there.
template <LieGroup G>
Result<void> IncrementalOptimiser<G>::take_poses(const std::vector<G>& poses,
                                                 IncrementalReport& report) {
  const std::vector<G> before = graph_.poses;
  graph_.poses = poses;
  relinearised_.clear();
  relinearise_all();
  linearise_again();
  system_.touch_all();
  if (const auto outcome = refactor(report); !outcome.ok) {
    graph_.poses = before;
    undo_relinearisation();
    return name_undetermined(outcome);
  }
  work_since_order_ = 0.0;
  // The remaining step at an optimum is below the stop criterion; the next update includes it.
  for (std::size_t k = 0; k < graph_.edges.size(); ++k)
    costs_.set(k, robust_cost(graph_, graph_.edges[k], kernel_));
  return {};
}

template <LieGroup G>
auto IncrementalOptimiser<G>::linearise(const PoseEdge<G>& edge) const -> IncrementalTerm<kDof> {
  EdgeTerms<G> terms;
  edge_terms(edge, origins_[index(edge.from)], origins_[index(edge.to)], terms);
  const double weight = edge.robust ? kernel_(terms.squared_error).weight : 1.0;
  IncrementalTerm<kDof> term;
  term.aa = weight * terms.from;
  term.ab = weight * terms.between;
  term.bb = weight * terms.to;
  term.ra = -weight * terms.from_gradient;
  term.rb = -weight * terms.to_gradient;
  return term;
}

template class IncrementalOptimiser<SE2d>;
template class IncrementalOptimiser<SE3d>;

}  // namespace wayfare
