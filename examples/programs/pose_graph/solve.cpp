#include "solve.hpp"

#ifdef WAYFARE_EXAMPLE_HAS_CHOLMOD
#include <wayfare/graph/cholmod_solver.hpp>
#endif
#include <wayfare/graph/eigen_solver.hpp>
#include <wayfare/graph/gnc.hpp>
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
  if (a.robust == Robust::gnc_geman_mcclure) options.loss = GncLoss::geman_mcclure;
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
    if (a.graduated()) return reject_outliers(graph, a, outcome);
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
