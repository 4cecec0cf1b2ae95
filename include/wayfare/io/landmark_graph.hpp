#pragma once

// The factor graph of a file with landmarks or priors.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <type_traits>
#include <unordered_map>
#include <utility>
#include <vector>

#include <wayfare/graph/edges.hpp>
#include <wayfare/graph/factor_graph.hpp>
#include <wayfare/graph/optimise.hpp>
#include <wayfare/io/detail/landmark_growth.hpp>
#include <wayfare/io/g2o.hpp>

namespace wayfare::io {

namespace landmark_detail {

template <class G, class Lists, template <class> class Kind>
struct LandmarkGraphOf;
template <class G, class... E, template <class> class Kind>
struct LandmarkGraphOf<G, MeasurementLists<E...>, Kind> {
  using Type = FactorGraph<Variables<G, typename LandmarkPosition<G>::Point>,
                           Edges<Kind<Between<G>>, Kind<E>...>>;
};
template <class E>
using Plain = E;

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

}  // namespace landmark_detail

/// Poses, landmarks, and every measurement a file may have of them.
template <LieGroup G>
using LandmarkGraph =
    typename landmark_detail::LandmarkGraphOf<G, typename GraphMeasurements<G>::Lists,
                                              landmark_detail::Plain>::Type;

/// An edge with a kernel of its own, which graduated non-convexity may reject if `robust`.
template <Edge E>
struct DoubtfulEdge : E {
  RobustKernel kernel;  ///< its loss
  bool robust = false;  ///< may be an outlier
};
/// Poses and landmarks, each edge with a kernel of its own.
template <LieGroup G>
using RobustLandmarkGraph =
    typename landmark_detail::LandmarkGraphOf<G, typename GraphMeasurements<G>::Lists,
                                              DoubtfulEdge>::Type;

namespace landmark_detail {

/// The factor graph of a file, which may have grown from call to call.
template <class Graph, LieGroup G>
class GraphOfFile {
 public:
  Graph graph;

  /// Adds the vertices, landmarks, edges and measurements that come after those of the last call,
  /// in this order. `kind(edge, doubtful)` is the graph's edge; edges between vertices that are not
  /// neighbours in the file, and those to landmarks, are doubtful.
  void add_new(const GraphFile<G>& file, const auto& kind) {
    for (; vertices_ < file.vertices.size(); ++vertices_) {
      const auto& vertex = file.vertices[vertices_];
      ends_.emplace(vertex.id, End{graph.add(vertex.pose).index, static_cast<int>(vertices_)});
    }
    for (; landmarks_ < file.landmarks.size(); ++landmarks_) {
      const auto& landmark = file.landmarks[landmarks_];
      ends_.emplace(landmark.id, End{graph.add(landmark.position).index, -1});
    }
    for (; edges_ < file.edges.size(); ++edges_) {
      const auto& edge = file.edges[edges_];
      const int step = ends_.at(edge.to).vertex - ends_.at(edge.from).vertex;
      add(kind(Between<G>{edge.measurement, edge.information}, step != 1 && step != -1),
          std::array{edge.from, edge.to}, EdgeVariables<G, G>{});
    }
    std::size_t* measured = measured_.data();
    const auto add_list = [&]<class E>(const std::vector<GraphMeasurement<E>>& list) {
      for (; *measured < list.size(); ++*measured) {
        const auto& m = list[*measured];
        const auto sensor = file.sensors.find(m.sensor);
        add(kind(sensor == file.sensors.end() ? m.edge : from_robot(m.edge, sensor->second),
                 E::Variables::kCount > 1),
            m.ids, typename E::Variables{});
      }
      ++measured;
    };
    std::apply([&](const auto&... list) { (add_list(list), ...); }, file.measurements);
  }

  /// Fixes what the file fixes; its first vertex, if that is nothing and it has no prior either.
  void anchor(const GraphFile<G>& file) {
    using Point = typename LandmarkPosition<G>::Point;
    for (const std::int64_t id : file.fixed) {
      if (ends_.at(id).vertex >= 0)
        graph.fix(VariableId<G>{ends_.at(id).variable});
      else
        graph.fix(VariableId<Point>{ends_.at(id).variable});
    }
    bool anchored = !file.fixed.empty();
    const auto look = [&]<class E>(const std::vector<GraphMeasurement<E>>& list) {
      anchored = anchored || (E::Variables::kCount == 1 && !list.empty());
    };
    std::apply([&](const auto&... list) { (look(list), ...); }, file.measurements);
    if (!anchored && !file.vertices.empty()) graph.fix(VariableId<G>{0});
  }

 private:
  struct End {
    int variable;
    int vertex;  // its number in the file, −1 of a landmark
  };

  template <class... X>
  void add(const auto& edge, const auto& ids, EdgeVariables<X...>) {
    std::size_t i = 0;
    const std::tuple<VariableId<X>...> ends{VariableId<X>{ends_.at(ids[i++]).variable}...};
    std::apply([&](const auto&... end) { graph.add(edge, end...); }, ends);
  }

  std::unordered_map<std::int64_t, End> ends_;
  std::size_t vertices_ = 0, landmarks_ = 0, edges_ = 0;  // that are in the graph
  std::array<std::size_t, std::tuple_size_v<typename GraphMeasurements<G>::Lists>> measured_{};
};

template <class Graph, LieGroup G>
[[nodiscard]] Graph to_graph(const GraphFile<G>& file, const auto& kind) {
  GraphOfFile<Graph, G> whole;
  whole.add_new(file, kind);
  whole.anchor(file);
  return std::move(whole.graph);
}

/// The kind of edge of to_robust_factor_graph.
[[nodiscard]] inline auto with_kernel(const RobustKernel& kernel, bool all) {
  return [=]<class E>(const E& edge, bool doubtful) {
    doubtful = doubtful || (all && E::Variables::kCount > 1);
    return DoubtfulEdge<E>{edge, doubtful ? kernel : RobustKernel{}, doubtful};
  };
}

}  // namespace landmark_detail

/// Variables are the file's vertices, then its landmarks, in its order. The first vertex is fixed
/// if the file fixes nothing and has no prior. `file` must be as returned by read_g2o (ids known).
template <LieGroup G>
[[nodiscard]] LandmarkGraph<G> to_factor_graph(const GraphFile<G>& file) {
  return landmark_detail::to_graph<LandmarkGraph<G>>(
      file, [](const auto& edge, bool) -> const auto& { return edge; });
}

/// The same graph with `kernel` on edges that may be outliers: those to landmarks, and between
/// vertices that are not neighbours in the file, or, with `all`, between any two. Priors are
/// trusted.
template <LieGroup G>
[[nodiscard]] RobustLandmarkGraph<G> to_robust_factor_graph(const GraphFile<G>& file,
                                                            const RobustKernel& kernel,
                                                            bool all = false) {
  return landmark_detail::to_graph<RobustLandmarkGraph<G>>(
      file, landmark_detail::with_kernel(kernel, all));
}

/// Copies the graph's poses and landmarks to those of `file`.
template <class Graph, LieGroup G>
void take_values(const Graph& graph, GraphFile<G>& file) {
  const auto& poses = graph.template all<G>();
  const auto& landmarks = graph.template all<typename LandmarkPosition<G>::Point>();
  for (std::size_t i = 0; i < file.vertices.size() && i < poses.size(); ++i)
    file.vertices[i].pose = poses[i];
  for (std::size_t i = 0; i < file.landmarks.size() && i < landmarks.size(); ++i)
    file.landmarks[i].position = landmarks[i];
}

/// Moves each landmark that is not fixed to where its first position measurement puts it, from the
/// poses of `file`. Others stay.
template <LieGroup G>
void place_landmarks(GraphFile<G>& file) {
  std::unordered_map<std::int64_t, const G*> poses;
  for (const auto& vertex : file.vertices) poses.emplace(vertex.id, &vertex.pose);
  std::unordered_map<std::int64_t, GraphLandmark<G>*> waiting;
  for (auto& landmark : file.landmarks) waiting.emplace(landmark.id, &landmark);
  for (const std::int64_t id : file.fixed) waiting.erase(id);
  for (const auto& m : file.template all<LandmarkPosition<G>>()) {
    const auto landmark = waiting.find(m.ids[1]);
    if (landmark == waiting.end()) continue;
    landmark->second->position = landmark_detail::seen_at(file, *poses.at(m.ids[0]), m);
    waiting.erase(landmark);
  }
}

/// Initialises the poses and landmarks of a file by optimising its graph as it grows, every
/// `vertices_per_step` vertices: each new pose is placed by its first edge to an earlier one, each
/// landmark by its first sighting (else it is where the file has it). Odometry alone may start the
/// optimiser too far from the optimum. A part that its edges do not determine is grown further. An
/// Error, with the file unchanged, if a vertex other than the first is fixed.
template <LieGroup G>
[[nodiscard]] Result<void> start_from_growth(GraphFile<G>& file,
                                             std::size_t vertices_per_step = 20) {
  if (file.vertices.empty() || vertices_per_step == 0) return {};
  if (auto ok = landmark_detail::Growth<G>::check(file); !ok) return ok;
  landmark_detail::Growth<G> growth(file);
  const std::size_t size = file.vertices.size();
  for (std::size_t first = 0; first < size; first += vertices_per_step) {
    const std::size_t end = std::min(first + vertices_per_step, size);
    for (std::size_t i = first; i < end; ++i) growth.add_vertex(i);
    growth.add_measurements(first, end);
    auto graph = to_factor_graph(growth.part());
    const auto report = optimise(graph, {.min_relative_gain = 1e-4});
    if (!report && report.error().code != ErrorCode::degenerate) return report.error();
    if (report) take_values(graph, growth.part());
  }
  growth.copy_to(file);
  return {};
}

}  // namespace wayfare::io
