#pragma once

#include <string>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/graph/pose_graph.hpp>

namespace wayfare::examples {

/// What a method made of a graph with false loops.
struct Rejection {
  std::vector<int> rejected;   ///< edges
  std::vector<int> undecided;  ///< some of them
  double total_s = 0.0, processor_s = 0.0;
};

/// Names of the methods.
[[nodiscard]] std::vector<std::string> method_names();

/// Rejects loops and optimises; `method` is one of method_names().
template <LieGroup G>
[[nodiscard]] Result<Rejection> reject(const std::string& method, PoseGraph<G>& graph);

/// Pairwise consistency maximisation (Mangelson, Dominic, Eustice, Vasudevan 2018): the loops of a
/// large clique among those whose pairs agree, by the cycle of two loops and the odometry between
/// them. Covariances times `scale`; the clique is greedy, by degree.
template <LieGroup G>
[[nodiscard]] std::vector<char> largest_clique_of_loops(const PoseGraph<G>& graph, double scale);

}  // namespace wayfare::examples
