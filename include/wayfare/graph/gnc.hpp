#pragma once

// Graduated non-convexity (Yang, Antonante, Tzoumas, Carlone 2020, "Graduated non-convexity for
// robust spatial perception"): a loss that sets outliers aside has many local minima, so it is
// reached through losses that grow into it from a convex one, each solved from the last's optimum.

#include <algorithm>
#include <cmath>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/graph/pose_graph.hpp>
#include <wayfare/graph/report.hpp>

namespace wayfare {

enum class GncLoss {
  truncated_least_squares,  ///< min(s, c²): an edge counts in full or, past c², not at all
  geman_mcclure,            ///< c² s/(c² + s)
};

struct GncOptions {
  GncLoss loss = GncLoss::truncated_least_squares;
  /// c² of an edge is the chi-square quantile of its degrees of freedom at this probability: the
  /// share of true edges that are to be kept where informations are honest. Larger: more false ones
  /// pass.
  double inlier_probability = 0.9999;
  /// μ changes by this factor from round to round. Larger: fewer rounds, less careful. The paper's.
  double growth = 1.4;
  int max_rounds = 200;
  /// Start from a spanning tree over trusted edges wherever those lead; false: from the graph's
  /// poses.
  bool start_from_trusted = true;
  /// Of each solve; its kernel is not used.
  OptimiseOptions optimise{};
};

/// The factor by which an edge with u = s/c² counts under the surrogate loss of control `mu`: for
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

struct GncReport {
  OptimiseReport optimisation;  ///< the last solve, with the rejected edges left out
  std::vector<int> rejected;    ///< edges found false, ascending; never a trusted one
  int rounds = 0;               ///< losses solved
  int iterations = 0;           ///< linear systems solved in all rounds
  double total_s = 0.0;
};

/// Optimises a graph whose `robust` edges may be plain wrong and says which are; the others are
/// trusted. Compiled in wayfare::slam for SE2d and SE3d. Errors as PoseGraphOptimiser's, the poses
/// then untouched.
template <LieGroup G>
Result<GncReport> optimise_gnc(PoseGraph<G>& graph, const GncOptions& options = {});

}  // namespace wayfare
