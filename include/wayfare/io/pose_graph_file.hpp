#pragma once

// Between the graph a file holds (vertices by id) and the graph that is optimised (poses by index).

#include <cstdint>
#include <string>
#include <unordered_map>

#include <wayfare/graph/pose_graph.hpp>
#include <wayfare/io/g2o.hpp>

namespace wayfare::io {

/// Pose i is vertex i of the file, labelled by its id. Edges between vertices that are not
/// neighbours in the file's order are marked robust: they are what a front end may get wrong.
/// `file` must be as read_g2o gives it (ids known and different).
template <LieGroup G>
[[nodiscard]] PoseGraph<G> to_pose_graph(const GraphFile<G>& file) {
  PoseGraph<G> graph;
  std::unordered_map<std::int64_t, int> index;
  for (const auto& vertex : file.vertices) {
    index.emplace(vertex.id, graph.add_pose(vertex.pose));
    graph.labels.push_back(std::to_string(vertex.id));
  }
  for (const auto& edge : file.edges) {
    const int from = index.at(edge.from), to = index.at(edge.to);
    const bool neighbours = to - from == 1 || from - to == 1;
    graph.edges.push_back({from, to, edge.measurement, edge.information, !neighbours});
  }
  for (const std::int64_t id : file.fixed) {
    if (const auto it = index.find(id); it != index.end()) graph.fixed.push_back(it->second);
  }
  return graph;
}

/// Writes the graph's poses back into the file they came from.
template <LieGroup G>
void take_poses(const PoseGraph<G>& graph, GraphFile<G>& file) {
  for (std::size_t i = 0; i < file.vertices.size() && i < graph.poses.size(); ++i) {
    file.vertices[i].pose = graph.poses[i];
  }
}

/// A file of the graph, ids as its indices.
template <LieGroup G>
[[nodiscard]] GraphFile<G> to_file(const PoseGraph<G>& graph) {
  GraphFile<G> file;
  for (int i = 0; i < graph.size(); ++i) {
    file.vertices.push_back({i, graph.poses[static_cast<std::size_t>(i)]});
  }
  for (const auto& edge : graph.edges) {
    file.edges.push_back({edge.from, edge.to, edge.measurement, edge.information});
  }
  file.fixed.assign(graph.fixed.begin(), graph.fixed.end());
  return file;
}

}  // namespace wayfare::io
