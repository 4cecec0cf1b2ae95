#include <wayfare/graph/eigen_solver.hpp>
#include <wayfare/graph/optimise.hpp>

#include "solve.hpp"

namespace wayfare::examples {

template <LieGroup G>
Result<OptimiseReport> solve_by_eigen(PoseGraph<G>& graph, const OptimiseOptions& options) {
  return PoseGraphOptimiser<G, EigenSolver<G::kDof>>().optimise(graph, options);
}

template Result<OptimiseReport> solve_by_eigen(PoseGraph2&, const OptimiseOptions&);
template Result<OptimiseReport> solve_by_eigen(PoseGraph3&, const OptimiseOptions&);

}  // namespace wayfare::examples
