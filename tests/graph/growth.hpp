#pragma once

// Growing graphs: a random walk with loop closures.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <wayfare/core/random.hpp>
#include <wayfare/graph/incremental.hpp>
#include <wayfare/graph/pose_graph.hpp>

#include "tangle.hpp"

namespace wayfare::tests {

/// A bounded walk of `poses` poses with noisy measurements, every third pose also measured from an
/// earlier one; poses by odometry. Optionally some loops are outliers.
template <class G>
PoseGraph<G> random_walk(Rng& rng, int poses, bool false_loops = false) {
  std::vector<G> truth(1);
  PoseGraph<G> graph;
  graph.add_pose(G());
  const auto join = [&](int from, int to, bool loop) {
    const auto a = static_cast<std::size_t>(from), b = static_cast<std::size_t>(to);
    G z = (truth[a].inverse() * truth[b]).plus(random_tangent<G>(rng, 0.03));
    if (loop && false_loops && rng.uniform(0.0, 1.0) < 0.2) z = z.plus(random_tangent<G>(rng, 2.0));
    const SquareOf<G> root = 5.0 * SquareOf<G>::Identity() +
                             random_tangent<G>(rng, 1.0) * random_tangent<G>(rng, 1.0).transpose();
    graph.edges.push_back({from, to, z, root * root.transpose(), loop});
  };
  for (int i = 1; i < poses; ++i) {
    TangentOf<G> step = random_tangent<G>(rng, 0.4);
    step[0] = 1.0;
    truth.push_back(truth.back() * G::exp(step));
    join(i - 1, i, false);
    graph.add_pose(graph.poses.back() * graph.edges.back().measurement);
    if (i < 2 || i % 3 != 0) continue;
    const int seen = static_cast<int>(rng.below(i - 1));
    rng.below(2) == 0 ? join(seen, i, true) : join(i, seen, true);
  }
  return graph;
}

/// A complete Gauss-Newton step per update: every pose that moved is relinearised, every change is
/// propagated.
inline constexpr IncrementalOptions kExact{
    .relinearise_step = 0.0, .solve_change = 0.0, .max_rounds = 1};

/// Largest difference of two lists of poses.
template <class G>
double apart(const std::vector<G>& a, const std::vector<G>& b) {
  double most = a.size() == b.size() ? 0.0 : 1e300;
  for (std::size_t i = 0; i < a.size() && i < b.size(); ++i)
    most = std::max(most, a[i].minus(b[i]).cwiseAbs().maxCoeff());
  return most;
}

}  // namespace wayfare::tests
