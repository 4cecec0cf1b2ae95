#include <wayfare/graph/optimise.hpp>

#include <cmath>
#include <cstdio>

#include <wayfare/graph/eigen_solver.hpp>

namespace wayfare {

Error undetermined_error(const std::string& name, const double* direction, int size) {
  std::string text = name + " is not fully determined by the edges";
  bool known = false;
  for (int i = 0; i < size; ++i) known = known || direction[i] != 0.0;
  for (int i = 0; known && i < size; ++i) {
    char number[32];
    const double rounded = std::round(1e3 * direction[i]) / 1e3 + 0.0;  // without a negative zero
    std::snprintf(number, sizeof number, "%s%.3g", i == 0 ? ", along (" : ", ", rounded);
    text += number;
  }
  return {ErrorCode::degenerate, known ? text + ")" : text};
}

template class GraphOptimiser<PoseGraph2>;
template class GraphOptimiser<PoseGraph3>;

template class ScalarSolver<3, detail::OrderedLlt<3>>;
template class ScalarSolver<6, detail::OrderedLlt<6>>;

}  // namespace wayfare
