#pragma once

#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/graph/pose_graph.hpp>
#include <wayfare/graph/report.hpp>

#include "arguments.hpp"

namespace wayfare::examples {

struct Outcome {
  OptimiseReport report;
  double start_s = 0.0;
  double total_s = 0.0;       ///< from the start's poses on
  int rounds = 0;             ///< of graduated non-convexity
  std::vector<int> rejected;  ///< edges found false
};

/// Places the poses as --init says and optimises them. `started` gets them as they were between.
template <LieGroup G>
Result<Outcome> solve(PoseGraph<G>& graph, const Arguments& a, std::vector<G>& started);

/// Solves the graph again and again as it grows edge by edge.
template <LieGroup G>
Result<void> replay(PoseGraph<G>& graph, const Arguments& a, Outcome& outcome);

/// With solvers that are not our own.
template <LieGroup G>
Result<OptimiseReport> solve_by_eigen(PoseGraph<G>& graph, const OptimiseOptions& options);
template <LieGroup G>
Result<OptimiseReport> solve_by_cholmod(PoseGraph<G>& graph, const OptimiseOptions& options);

}  // namespace wayfare::examples
