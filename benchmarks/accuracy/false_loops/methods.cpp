#include "methods.hpp"

#include <time.h>

#include <utility>

#include <wayfare/core/statistics.hpp>
#include <wayfare/graph/gnc.hpp>
#include <wayfare/graph/loop_consistency.hpp>
#include <wayfare/graph/optimise.hpp>

namespace wayfare::examples {
namespace {

template <LieGroup G>
Result<Rejection> by_cycles(PoseGraph<G>& graph) {
  auto report = optimise_consistent_loops(graph);
  if (!report) return report.error();
  return Rejection{std::move(report->rejected), std::move(report->undecided)};
}

template <LieGroup G>
Result<Rejection> by_gnc(PoseGraph<G>& graph) {
  auto report = optimise_gnc(graph);
  if (!report) return report.error();
  return Rejection{std::move(report->rejected), {}};
}

/// Rejected are the loops beyond their quantile at the end.
template <LieGroup G>
Result<Rejection> by_dcs(PoseGraph<G>& graph) {
  OptimiseOptions options;
  options.kernel = {RobustKernelKind::dynamic_covariance_scaling, 1.0};
  if (auto report = optimise(graph, options); !report) return report.error();
  Rejection found;
  const double gate = chi_square_quantile(0.9999, ManifoldTraits<G>::kDof);
  for (std::size_t k = 0; k < graph.edges.size(); ++k)
    if (graph.edges[k].robust && squared_error(graph, graph.edges[k]) > gate)
      found.rejected.push_back(static_cast<int>(k));
  return found;
}

template <LieGroup G>
Result<Rejection> by_clique(PoseGraph<G>& graph, double scale) {
  const std::vector<char> in = largest_clique_of_loops(graph, scale);
  Rejection found;
  PoseGraph<G> part{graph.poses, {}, graph.fixed, graph.labels};
  for (std::size_t k = 0; k < in.size(); ++k) {
    if (graph.edges[k].robust && in[k] == 0) {
      found.rejected.push_back(static_cast<int>(k));
    } else {
      part.edges.push_back(graph.edges[k]);
    }
  }
  auto done = start_from_chordal(part);
  if (!done) return done.error();
  if (auto report = optimise(part); !report) return report.error();
  graph.poses = std::move(part.poses);
  return found;
}

/// Of all threads: other programs do not change it.
double processor_s() {
  timespec now{};
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace

std::vector<std::string> method_names() { return {"cycles", "gnc", "dcs", "pcm", "pcm-scaled"}; }

template <LieGroup G>
Result<Rejection> reject(const std::string& method, PoseGraph<G>& graph) {
  double total_s = 0.0;
  const double begin_s = processor_s();
  const auto found = [&]() -> Result<Rejection> {
    const PhaseTimer timer(total_s);
    if (auto done = start_from_odometry(graph); !done) return done.error();
    if (method == "gnc") return by_gnc(graph);
    if (method == "dcs") return by_dcs(graph);
    if (method == "pcm") return by_clique(graph, 1.0);
    if (method == "pcm-scaled") return by_clique(graph, 1.0 / 32.0);
    return by_cycles(graph);
  }();
  if (!found) return found.error();
  Rejection timed = *found;
  timed.total_s = total_s;
  timed.processor_s = processor_s() - begin_s;
  return timed;
}

template Result<Rejection> reject(const std::string&, PoseGraph<SE2d>&);
template Result<Rejection> reject(const std::string&, PoseGraph<SE3d>&);

}  // namespace wayfare::examples
