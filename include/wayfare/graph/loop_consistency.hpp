#pragma once

// False loop closures, also in groups that agree with each other: loops are accepted in the order
// of their significance: the probability that a false loop closes its cycle with the odometry and
// the loops accepted before as well.

#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/graph/pose_graph.hpp>
#include <wayfare/graph/report.hpp>

namespace wayfare {

/// Gate and significance of optimise_consistent_loops.
struct LoopConsistencyOptions {
  /// A cycle agrees if its squared Mahalanobis error is below the chi-square quantile of its
  /// degrees of freedom at this probability. Larger: more false loops pass.
  double inlier_probability = 0.9999;
  /// Expected number of false loops accepted: a loop is accepted if a false one
  /// would agree as well with a probability of at most this by the number of loops compared and not
  /// accepted so far. Larger: more loops along uncertain paths are accepted, true and false ones.
  double max_false = 0.05;
  /// Factor of all covariances; 0: estimated from the loops' agreement with the odometry, between
  /// 1/32 and 1. Smaller: fewer false loops pass.
  double noise_scale = 0.0;
  /// Of each solve; its kernel is not used.
  OptimiseOptions optimise{};
};

/// What optimise_consistent_loops did.
struct LoopConsistencyReport {
  OptimiseReport optimisation;  ///< the last solve, without the rejected edges
  std::vector<int> rejected;    ///< edges that are not part of the solution, ascending
  /// Rejected edges that agree, but so vaguely that a false one might as well; ascending.
  std::vector<int> undecided;
  double noise_scale = 1.0;  ///< factor of the covariances
  int rounds = 0;            ///< passes over the loops
  int iterations = 0;        ///< linear systems solved
  double total_s = 0.0;      ///< wall time
};

/// Optimises a pose graph of which some loops (edges marked `robust`) may be false, and reports
/// which are. The other edges are trusted and must join all poses k and k + 1.
///
/// Each loop closes a cycle with the path of fewest edges over trusted and accepted edges. With r
/// the cycle's error, S its covariance (path and loop) and D the covariance of r for two unrelated
/// poses, d² = rᵀS⁻¹r is the agreement, and V dⁿ √(det S / ((2π)ⁿ det(S + D))) the probability that
/// a false loop agrees as well (V: volume of the unit ball of n dimensions). Round by round the
/// least probable are accepted, which shortens the paths of the others. Members of a group of false
/// loops thus do not support each other until one of them agrees with the rest. Rejected loops that
/// agree with the optimum are readmitted (eᵀΩe below its quantile).
///
/// Errors, with the poses unchanged: those of GraphOptimiser, options out of range, poses k and k +
/// 1 that no trusted edge joins. Compiled in wayfare::graph for SE2d and SE3d. Single-threaded but
/// for the solves; the result does not depend on the number of threads.
template <LieGroup G>
Result<LoopConsistencyReport> optimise_consistent_loops(PoseGraph<G>& graph,
                                                        const LoopConsistencyOptions& options = {});

}  // namespace wayfare
