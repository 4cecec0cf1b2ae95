#include <wayfare/graph/cholmod_solver.hpp>
#include <wayfare/graph/optimise.hpp>

#include "solve.hpp"

namespace wayfare::examples {

template <LieGroup G>
Result<OptimiseReport> solve_by_cholmod(PoseGraph<G>& graph, const OptimiseOptions& options) {
  return PoseGraphOptimiser<G, CholmodSolver<G::kDof>>().optimise(graph, options);
}

template Result<OptimiseReport> solve_by_cholmod(PoseGraph2&, const OptimiseOptions&);
template Result<OptimiseReport> solve_by_cholmod(PoseGraph3&, const OptimiseOptions&);

}  // namespace wayfare::examples
