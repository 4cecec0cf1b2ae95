#pragma once

#include <utility>
#include <vector>

#ifdef WAYFARE_EXAMPLE_HAS_CHOLMOD
#include <wayfare/graph/cholmod_solver.hpp>
#endif
#include <wayfare/graph/eigen_solver.hpp>
#include <wayfare/graph/gnc.hpp>
#include <wayfare/graph/loop_consistency.hpp>
#include <wayfare/graph/optimise.hpp>
#include <wayfare/io/g2o.hpp>

#include "options.hpp"

namespace wayfare::examples {

struct Outcome {
  OptimiseReport report;
  double start_s = 0.0;
  double total_s = 0.0;        ///< of the optimisation
  int rounds = 0;              ///< of graduated non-convexity
  std::vector<int> rejected;   ///< outlier edges
  std::vector<int> undecided;  ///< some of them
  const char* steps = "";      ///< of --incremental
};

void print(const Outcome& outcome, const Arguments& a);
/// Writes the numbers for --json; in doubt if the iterations ended before the cost was lowest.
Result<Doubt> finish(std::size_t vertices, std::size_t edges, const Outcome& outcome,
                     const Arguments& a);

/// Runs `work` and adds its seconds.
template <class Work>
Result<void> timed(double& seconds, const Work& work) {
  const PhaseTimer timer(seconds);
  return work();
}

/// By the solver of --solver.
template <class Graph>
Result<void> optimise_by(Graph& graph, const Arguments& a, Outcome& outcome) {
  const auto with = [&]<class Solver>(GraphOptimiser<Graph, Solver> optimiser) -> Result<void> {
    auto report = optimiser.optimise(graph, a.options);
    if (!report) return report.error();
    outcome.report = std::move(*report);
    return {};
  };
  constexpr int kBlock = Graph::kBlock;
  if (a.solver == SolverChoice::eigen) return with(GraphOptimiser<Graph, EigenSolver<kBlock>>());
#ifdef WAYFARE_EXAMPLE_HAS_CHOLMOD
  if (a.solver == SolverChoice::cholmod)
    return with(GraphOptimiser<Graph, CholmodSolver<kBlock>>());
#endif
  return with(GraphOptimiser<Graph>());
}

template <class Graph>
Result<void> reject_outliers(Graph& graph, const Arguments& a, Outcome& outcome) {
  if (a.solver != SolverChoice::block) return bad_use("--robust gnc uses the block solver only");
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

template <LieGroup G>
Result<void> reject_false_loops(PoseGraph<G>& graph, const Arguments& a, Outcome& outcome) {
  if (a.solver != SolverChoice::block) return bad_use("--robust cycles uses the block solver only");
  LoopConsistencyOptions options;
  options.inlier_probability = a.inlier_probability;
  options.optimise = a.options;
  auto report = optimise_consistent_loops(graph, options);
  if (!report) return report.error();
  outcome.report = std::move(report->optimisation);
  outcome.rejected = std::move(report->rejected);
  outcome.undecided = std::move(report->undecided);
  outcome.rounds = report->rounds;
  return {};
}

/// Optimises a file with landmarks or priors and writes what is asked for.
Result<Doubt> run_landmarks(io::GraphFile<SE2d>& file, const Arguments& a);
Result<Doubt> run_landmarks(io::GraphFile<SE3d>& file, const Arguments& a);

}  // namespace wayfare::examples
