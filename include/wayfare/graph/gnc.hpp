#pragma once

// Graduated non-convexity (Yang, Antonante, Tzoumas, Carlone 2020, "Graduated non-convexity for
// robust spatial perception"): a loss that rejects outliers has many local minima, so a sequence of
// surrogate losses leads to it from a convex one, each solved from the last one's optimum.

#include <algorithm>
#include <cmath>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/graph/pose_graph.hpp>
#include <wayfare/graph/report.hpp>

namespace wayfare {

/// The loss that the sequence ends with.
enum class GncLoss {
  truncated_least_squares,  ///< min(s, c²): constant beyond c²
  geman_mcclure,            ///< c² s/(c² + s)
};

/// Loss, gate and sequence of optimise_gnc.
struct GncOptions {
  GncLoss loss = GncLoss::truncated_least_squares;  ///< of possible outliers
  /// c² of an edge is the chi-square quantile of its degrees of freedom at this probability: the
  /// fraction of inliers accepted if the information matrices are consistent. Larger: more outliers
  /// pass.
  double inlier_probability = 0.9999;
  /// Factor of μ between rounds, as in the paper. Larger: fewer rounds, less robust.
  double growth = 1.4;
  int max_rounds = 200;  ///< losses solved at most
  /// Start from a spanning tree that prefers trusted edges; false: from the graph's poses. Factor
  /// graphs start from their values, improved with equal weights of all edges that may be outliers.
  bool start_from_trusted = true;
  /// Of each solve; its kernel is not used.
  OptimiseOptions optimise{};
};

/// Weight of an edge with u = s/c² under the surrogate loss with control parameter `mu`: for
/// truncated least squares (eq. 14) convex near μ = 0 and exact as μ → ∞; for Geman-McClure (eq.
/// 12) convex as μ → ∞ and exact at μ = 1.
[[nodiscard]] inline double gnc_weight(GncLoss loss, double u, double mu) {
  if (loss == GncLoss::geman_mcclure) {
    const double k = mu / (u + mu);
    return k * k;
  }
  if (u <= mu / (mu + 1.0)) return 1.0;
  if (u >= (mu + 1.0) / mu) return 0.0;
  return std::clamp(std::sqrt(mu * (mu + 1.0) / u) - mu, 0.0, 1.0);
}

/// What optimise_gnc did.
struct GncReport {
  OptimiseReport optimisation;  ///< the last solve, without the rejected edges
  /// Outlier edges, ascending; never a trusted one. Those of a factor graph are counted type by
  /// type, in the order of FactorGraph::each_edge.
  std::vector<int> rejected;
  int rounds = 0;        ///< losses solved
  int iterations = 0;    ///< linear systems solved in all rounds
  double total_s = 0.0;  ///< wall time
};

/// Optimises a graph of which some edges may be outliers and reports which are; the others are
/// trusted. They are a pose graph's edges marked `robust`, and a factor graph's edges whose member
/// `bool robust` is true, or without such a member those of types with a kernel, which is not used.
/// Errors, with the values unchanged: those of GraphOptimiser, also where a variable has outlier
/// edges only. Compiled in wayfare::graph for PoseGraph2 and PoseGraph3.
template <class Graph>
Result<GncReport> optimise_gnc(Graph& graph, const GncOptions& options = {});

}  // namespace wayfare

#include <wayfare/graph/detail/gnc_rounds.hpp>
