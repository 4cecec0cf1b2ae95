#include <wayfare/graph/incremental.hpp>

#include "solve.hpp"

namespace wayfare::examples {

template <LieGroup G>
Result<void> replay(PoseGraph<G>& graph, const Arguments& a, Outcome& outcome) {
  if (a.graduated() || a.solver != SolverChoice::block)
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

template Result<void> replay(PoseGraph2&, const Arguments&, Outcome&);
template Result<void> replay(PoseGraph3&, const Arguments&, Outcome&);

}  // namespace wayfare::examples
