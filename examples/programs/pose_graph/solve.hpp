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
  double total_s = 0.0;       ///< of the optimisation
  int rounds = 0;             ///< of graduated non-convexity
  std::vector<int> rejected;  ///< outlier edges
};

/// Initialises the poses by --init, stores them in `initial` and optimises them.
template <LieGroup G>
Result<Outcome> solve(PoseGraph<G>& graph, const Arguments& a, std::vector<G>& initial);

}  // namespace wayfare::examples
