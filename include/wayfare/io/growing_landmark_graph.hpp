#pragma once

// The graph of a file with landmarks, optimised as it grows.

#include <cstddef>
#include <string>

#include <wayfare/graph/incremental.hpp>
#include <wayfare/io/landmark_graph.hpp>

namespace wayfare::io {

/// What optimise_growing did.
struct GrowthReport {
  double cost = 0.0;       ///< Σ ρ(eᵀΩe) at the end
  int rounds = 0;          ///< linear systems solved
  bool fell_back = false;  ///< some step; as in IncrementalReport
};

/// Optimises the graph of a file by the incremental optimiser: adds vertex by vertex in the order
/// of the file, with all that is then measured, and solves after each. Poses and landmarks are
/// placed as by start_from_growth; `kernel` and `all` are those of to_robust_factor_graph. A part
/// that its edges do not determine waits for more. Errors, with the file unchanged: a vertex other
/// than the first is fixed, a landmark is not measured from any vertex, and those of the optimiser.
template <LieGroup G>
[[nodiscard]] Result<GrowthReport> optimise_growing(
    GraphFile<G>& file, const RobustKernel& kernel = {}, bool all = false,
    const IncrementalOptions& options = kIncrementalDefaults<RobustLandmarkGraph<G>>) {
  if (auto ok = landmark_detail::Growth<G>::check(file); !ok) return ok.error();
  landmark_detail::Growth<G> growth(file);
  if (const auto* landmark = growth.never_seen())
    return Error{ErrorCode::unsupported,
                 "landmark " + std::to_string(landmark->id) + " is not measured from any vertex"};
  landmark_detail::GraphOfFile<RobustLandmarkGraph<G>, G> whole;
  IncrementalGraphOptimiser<RobustLandmarkGraph<G>> growing;
  GrowthReport sum;
  Result<void> last;
  for (std::size_t step = 0; step < file.vertices.size(); ++step) {
    growth.add_vertex(step);
    growth.add_measurements(step, step + 1);
    whole.add_new(growth.part(), landmark_detail::with_kernel(kernel, all));
    if (step == 0) whole.anchor(file);
    if (auto added = growing.append(whole.graph); !added) return added.error();
    const auto report = growing.update(options);
    last = report ? Result<void>{} : report.error();
    if (report) {
      sum = {report->cost, sum.rounds + report->rounds, sum.fell_back || report->fell_back};
      take_values(growing.graph(), growth.part());
    } else if (report.error().code != ErrorCode::degenerate) {
      return report.error();
    }
  }
  if (!last) return last.error();
  growth.copy_to(file);
  return sum;
}

}  // namespace wayfare::io
