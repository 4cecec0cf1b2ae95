#include "program.hpp"

#ifdef WAYFARE_EXAMPLE_HAS_CHOLMOD
#include <wayfare/graph/cholmod_solver.hpp>
#endif
#include <wayfare/graph/eigen_solver.hpp>
#include <wayfare/graph/gnc.hpp>
#include <wayfare/graph/incremental.hpp>
#include <wayfare/graph/optimise.hpp>

namespace wayfare::examples {
namespace {

template <LieGroup G>
Result<OptimiseReport> optimise_with(PoseGraph<G>& graph, const Arguments& a) {
  switch (a.solver) {
    case SolverChoice::eigen:
      return PoseGraphOptimiser<G, EigenSolver<G::kDof>>().optimise(graph, a.options);
    case SolverChoice::cholmod:
#ifdef WAYFARE_EXAMPLE_HAS_CHOLMOD
      return PoseGraphOptimiser<G, CholmodSolver<G::kDof>>().optimise(graph, a.options);
#endif
    case SolverChoice::block:
      break;
  }
  return PoseGraphOptimiser<G>().optimise(graph, a.options);
}

template <LieGroup G>
Result<void> reject_outliers(PoseGraph<G>& graph, const Arguments& a, Outcome& outcome) {
  if (a.solver != SolverChoice::block)
    return Error{ErrorCode::unsupported, "--robust gnc uses the block solver only"};
  GncOptions options;
  options.loss = *a.gnc;
  options.inlier_probability = a.inlier_probability;
  options.start_from_trusted = a.start_from_trusted;
  options.optimise = a.options;
  auto report = optimise_gnc(graph, options);
  if (!report) return report.error();
  outcome.report = std::move(report->optimisation);
  outcome.rejected = std::move(report->rejected);
  outcome.rounds = report->rounds;
  return {};
}

/// Adds edge by edge and solves the graph after each.
template <LieGroup G>
Result<void> replay(PoseGraph<G>& graph, const Arguments& a, Outcome& outcome) {
  if (a.gnc || a.solver != SolverChoice::block)
    return Error{ErrorCode::unsupported,
                 "--incremental needs a kernel or none, and the block solver"};
  for (const int pose : graph.fixed) {
    if (pose == 0) continue;
    return Error{ErrorCode::unsupported, "--incremental fixes the first vertex only; vertex " +
                                             graph.label(pose) + " is fixed in the file"};
  }
  OptimiseReport& report = outcome.report;
  report.initial_chi2 = chi2(graph);
  report.initial_cost = robust_cost(graph, a.options.kernel);
  IncrementalOptimiser<G> optimiser(a.options.kernel);
  if (auto added = optimiser.add_pose(graph.poses.front()); !added) return added.error();
  for (const ReplayStep<G>& step : replay_steps(graph)) {
    if (step.new_pose >= 0) {
      if (auto added = optimiser.add_pose(step.placed(optimiser.poses())); !added)
        return added.error();
    }
    if (auto added = optimiser.add_edge(step.edge); !added) return added;
    const auto update = optimiser.update();
    if (!update) return update.error();
    report.iterations += update->rounds;
    report.fell_back = report.fell_back || update->fell_back;
  }
  if (optimiser.poses().size() != graph.poses.size())
    return Error{ErrorCode::degenerate,
                 "the edges do not connect every vertex in the order of the file"};
  graph.poses = optimiser.poses();
  report.final_chi2 = chi2(graph);
  report.final_cost = robust_cost(graph, a.options.kernel);
  return {};
}

}  // namespace

template <LieGroup G>
Result<Outcome> solve(PoseGraph<G>& graph, const Arguments& a, std::vector<G>& initial) {
  Outcome outcome;
  const auto timed = [](double& seconds, const auto& work) -> Result<void> {
    const PhaseTimer timer(seconds);
    return work();
  };
  auto done = timed(outcome.start_s, [&] { return start_from(graph, a.start); });
  if (!done) return done.error();
  initial = graph.poses;
  done = timed(outcome.total_s, [&]() -> Result<void> {
    if (a.incremental) return replay(graph, a, outcome);
    if (a.gnc) return reject_outliers(graph, a, outcome);
    auto report = optimise_with(graph, a);
    if (!report) return report.error();
    outcome.report = std::move(*report);
    return {};
  });
  if (!done) return done.error();
  return outcome;
}

template Result<Outcome> solve(PoseGraph2&, const Arguments&, std::vector<SE2d>&);
template Result<Outcome> solve(PoseGraph3&, const Arguments&, std::vector<SE3d>&);

}  // namespace wayfare::examples
