#pragma once

#include <string>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/graph/pose_graph.hpp>
#include <wayfare/io/landmark_graph.hpp>

namespace wayfare::examples {

/// An SVG of the graph with the poses `before` and with its poses; `rejected` are edges.
template <LieGroup G>
[[nodiscard]] std::string draw(const PoseGraph<G>& graph, const std::vector<G>& before,
                               const std::vector<int>& rejected);
/// An SVG of the poses, the edges between them and the landmarks of a file, before and after;
/// `rejected` are edges of its factor graph.
template <LieGroup G>
[[nodiscard]] std::string draw(const io::GraphFile<G>& before, const io::GraphFile<G>& after,
                               const std::vector<int>& rejected);

/// One row per pose: label and upper triangle of the covariance, units in the heading. Without the
/// `rejected` edges.
template <LieGroup G>
[[nodiscard]] Result<std::string> marginals_table(const PoseGraph<G>& graph,
                                                  const std::vector<int>& rejected,
                                                  const RobustKernel& kernel);

/// One row per pose and landmark; what is not a landmark's is empty.
template <LieGroup G>
[[nodiscard]] Result<std::string> marginals_table(const io::GraphFile<G>& file);

/// One row per edge: the labels of its vertices.
template <LieGroup G>
[[nodiscard]] std::string edges_table(const PoseGraph<G>& graph, const std::vector<int>& edges);
/// The same of edges of a file's factor graph, to vertices or landmarks.
template <LieGroup G>
[[nodiscard]] std::string edges_table(const io::GraphFile<G>& file, const std::vector<int>& edges);

}  // namespace wayfare::examples
