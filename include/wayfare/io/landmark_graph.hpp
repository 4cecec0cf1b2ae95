#pragma once

// The factor graph of a file with landmarks or priors.

#include <cstddef>
#include <cstdint>
#include <tuple>
#include <unordered_map>
#include <utility>
#include <vector>

#include <wayfare/graph/edges.hpp>
#include <wayfare/graph/factor_graph.hpp>
#include <wayfare/io/g2o.hpp>

namespace wayfare::io {

namespace detail {

template <class G, class Lists>
struct LandmarkGraphOf;
template <class G, class... E>
struct LandmarkGraphOf<G, MeasurementLists<E...>> {
  using Type =
      FactorGraph<Variables<G, typename LandmarkPosition<G>::Point>, Edges<Between<G>, E...>>;
};

/// The edge of a measurement by a sensor that is not at the robot's origin.
template <class E, class G>
[[nodiscard]] E from_robot(E edge, const G&) {
  return edge;  // g2o's priors of positions are of the robot's origin
}
template <class G>
[[nodiscard]] PoseOf<G> from_robot(PoseOf<G> edge, const G& T_robot_sensor) {
  edge.T_body_sensor = T_robot_sensor;
  return edge;
}
template <class G>
[[nodiscard]] LandmarkPosition<G> from_robot(const LandmarkPosition<G>& edge,
                                             const G& T_robot_sensor) {
  // T⁻¹X⁻¹l − z = Rᵀ (X⁻¹l − Tz)
  const auto r = T_robot_sensor.rotation().matrix();
  return {T_robot_sensor * edge.measurement, r * edge.information * r.transpose()};
}

}  // namespace detail

/// Poses, landmarks, and every measurement a file may have of them.
template <LieGroup G>
using LandmarkGraph =
    typename detail::LandmarkGraphOf<G, typename GraphMeasurements<G>::Lists>::Type;

/// Variables are the file's vertices, then its landmarks, in its order. The first vertex is fixed
/// if the file fixes nothing and has no prior. `file` must be as returned by read_g2o (ids known).
template <LieGroup G>
[[nodiscard]] LandmarkGraph<G> to_factor_graph(const GraphFile<G>& file) {
  using Point = typename LandmarkPosition<G>::Point;
  LandmarkGraph<G> graph;
  std::unordered_map<std::int64_t, int> index;
  for (const auto& vertex : file.vertices) index.emplace(vertex.id, graph.add(vertex.pose).index);
  for (const auto& landmark : file.landmarks)
    index.emplace(landmark.id, graph.add(landmark.position).index);
  for (const std::int64_t id : file.fixed) {
    const int variable = index.at(id);
    if (std::cmp_less(variable, file.vertices.size()))
      graph.fix(VariableId<G>{variable});
    else
      graph.fix(VariableId<Point>{variable});
  }
  const auto add = [&]<class E, class... X>(const E& edge, const auto& ids, EdgeVariables<X...>) {
    std::size_t i = 0;
    const std::tuple<VariableId<X>...> ends{VariableId<X>{index.at(ids[i++])}...};
    std::apply([&](const auto&... end) { graph.add(edge, end...); }, ends);
  };
  for (const auto& edge : file.edges)
    add(Between<G>{edge.measurement, edge.information}, std::array{edge.from, edge.to},
        EdgeVariables<G, G>{});
  bool anchored = !file.fixed.empty();
  const auto add_all = [&]<class E>(const std::vector<GraphMeasurement<E>>& list) {
    anchored = anchored || (E::Variables::kCount == 1 && !list.empty());
    for (const auto& m : list) {
      const auto sensor = file.sensors.find(m.sensor);
      add(sensor == file.sensors.end() ? m.edge : detail::from_robot(m.edge, sensor->second), m.ids,
          typename E::Variables{});
    }
  };
  std::apply([&](const auto&... list) { (add_all(list), ...); }, file.measurements);
  if (!anchored && !file.vertices.empty()) graph.fix(VariableId<G>{0});
  return graph;
}

/// Copies the graph's poses and landmarks to those of `file`.
template <LieGroup G>
void take_values(const LandmarkGraph<G>& graph, GraphFile<G>& file) {
  const auto& poses = graph.template all<G>();
  const auto& landmarks = graph.template all<typename LandmarkPosition<G>::Point>();
  for (std::size_t i = 0; i < file.vertices.size() && i < poses.size(); ++i)
    file.vertices[i].pose = poses[i];
  for (std::size_t i = 0; i < file.landmarks.size() && i < landmarks.size(); ++i)
    file.landmarks[i].position = landmarks[i];
}

}  // namespace wayfare::io
