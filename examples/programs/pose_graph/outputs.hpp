#pragma once

#include <string>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/graph/pose_graph.hpp>

namespace wayfare::examples {

/// The graph at the poses `before` and at its own, beside each other; `rejected` are edges.
template <LieGroup G>
[[nodiscard]] std::string draw(const PoseGraph<G>& graph, const std::vector<G>& before,
                               const std::vector<int>& rejected);

/// One row a pose: its label and the upper triangle of its covariance, with units in the heading.
/// `rejected` edges do not count.
template <LieGroup G>
[[nodiscard]] Result<std::string> marginals_table(const PoseGraph<G>& graph,
                                                  const std::vector<int>& rejected,
                                                  const RobustKernel& kernel);

/// One row an edge: its ends' labels.
template <LieGroup G>
[[nodiscard]] std::string edges_table(const PoseGraph<G>& graph, const std::vector<int>& edges);

}  // namespace wayfare::examples
