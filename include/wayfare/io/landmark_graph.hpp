#pragma once

// The factor graph of a file with landmarks or priors.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <tuple>
#include <type_traits>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include <wayfare/graph/edges.hpp>
#include <wayfare/graph/factor_graph.hpp>
#include <wayfare/graph/optimise.hpp>
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
  RobustKernel kernel;
  bool robust = false;
};
template <LieGroup G>
using RobustLandmarkGraph =
    typename landmark_detail::LandmarkGraphOf<G, typename GraphMeasurements<G>::Lists,
                                              DoubtfulEdge>::Type;

namespace landmark_detail {

/// `kind(edge, doubtful)` is the graph's edge; edges between vertices that are not neighbours in
/// the file, and those to landmarks, are doubtful.
template <class Graph, LieGroup G>
[[nodiscard]] Graph to_graph(const GraphFile<G>& file, const auto& kind) {
  using Point = typename LandmarkPosition<G>::Point;
  Graph graph;
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
  const auto add = [&]<class E, class... X>(const E& edge, bool doubtful, const auto& ids,
                                            EdgeVariables<X...>) {
    std::size_t i = 0;
    const std::tuple<VariableId<X>...> ends{VariableId<X>{index.at(ids[i++])}...};
    std::apply([&](const auto&... end) { graph.add(kind(edge, doubtful), end...); }, ends);
  };
  for (const auto& edge : file.edges) {
    const int step = index.at(edge.to) - index.at(edge.from);
    add(Between<G>{edge.measurement, edge.information}, step != 1 && step != -1,
        std::array{edge.from, edge.to}, EdgeVariables<G, G>{});
  }
  bool anchored = !file.fixed.empty();
  const auto add_all = [&]<class E>(const std::vector<GraphMeasurement<E>>& list) {
    constexpr bool kIsPrior = E::Variables::kCount == 1;
    anchored = anchored || (kIsPrior && !list.empty());
    for (const auto& m : list) {
      const auto sensor = file.sensors.find(m.sensor);
      add(sensor == file.sensors.end() ? m.edge : from_robot(m.edge, sensor->second), !kIsPrior,
          m.ids, typename E::Variables{});
    }
  };
  std::apply([&](const auto&... list) { (add_all(list), ...); }, file.measurements);
  if (!anchored && !file.vertices.empty()) graph.fix(VariableId<G>{0});
  return graph;
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
      file, [&]<class E>(const E& edge, bool doubtful) {
        doubtful = doubtful || (all && E::Variables::kCount > 1);
        return DoubtfulEdge<E>{edge, doubtful ? kernel : RobustKernel{}, doubtful};
      });
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

namespace landmark_detail {

/// A file's graph in the order of its vertices: a landmark comes with the first vertex it is
/// measured from, an edge with the last of its ends.
template <LieGroup G>
class Growth {
 public:
  using Point = typename LandmarkPosition<G>::Point;
  static constexpr std::size_t kNever = std::numeric_limits<std::size_t>::max();

  explicit Growth(const GraphFile<G>& whole) : whole_(whole), edges_(whole.vertices.size()) {
    part_.sensors = whole.sensors;
    for (std::size_t i = 0; i < whole.vertices.size(); ++i) steps_.emplace(whole.vertices[i].id, i);
    for (std::size_t i = 0; i < whole.landmarks.size(); ++i) {
      steps_.emplace(whole.landmarks[i].id, kNever);
      landmarks_.emplace(whole.landmarks[i].id, i);
    }
    each_measurement([&](const auto& m, std::size_t) {
      std::size_t& last = steps_.at(m.ids.back());
      if (landmarks_.contains(m.ids.back())) last = std::min(last, steps_.at(m.ids.front()));
    });
    for (std::size_t k = 0; k < whole.edges.size(); ++k)
      at(std::max(steps_.at(whole.edges[k].from), steps_.at(whole.edges[k].to))).push_back(k);
  }

  /// Adds vertex `step` and what comes with it.
  void add_vertex(std::size_t step) {
    GraphVertex<G> vertex = whole_.vertices[step];
    bool placed = step == 0;
    for (const std::size_t k : at(step)) {
      const GraphEdge<G>& edge = whole_.edges[k];
      if (!placed && edge.to == vertex.id)
        vertex.pose = pose(edge.from) * edge.measurement, placed = true;
      else if (!placed)
        vertex.pose = pose(edge.to) * edge.measurement.inverse(), placed = true;
      part_.edges.push_back(edge);
    }
    part_.vertices.push_back(vertex);
  }

  void add_measurements(std::size_t first, std::size_t end) {
    each_measurement([&]<class E>(const GraphMeasurement<E>& m, std::size_t step) {
      if (step < first || step >= end) return;
      if constexpr (E::Variables::kCount == 2) add_landmark(m);
      part_.template all<E>().push_back(m);
    });
  }

  GraphFile<G>& part() { return part_; }
  /// The vertices and landmarks of the part in the order of the whole.
  void copy_to(GraphFile<G>& file) const {
    file.vertices = part_.vertices;
    for (const auto& landmark : part_.landmarks)
      file.landmarks[landmarks_.at(landmark.id)].position = landmark.position;
  }

 private:
  std::vector<std::size_t>& at(std::size_t step) { return edges_[step]; }
  [[nodiscard]] const G& pose(std::int64_t id) const { return part_.vertices[steps_.at(id)].pose; }
  /// visit(measurement, the step at which its ends are there)
  template <class Visit>
  void each_measurement(const Visit& visit) {
    const auto visit_all = [&](const auto& list) {
      for (const auto& m : list)
        visit(m, std::max(steps_.at(m.ids.front()), steps_.at(m.ids.back())));
    };
    std::apply([&](const auto&... list) { (visit_all(list), ...); }, whole_.measurements);
  }
  template <class E>
  void add_landmark(const GraphMeasurement<E>& m) {
    if (!added_.emplace(m.ids[1]).second) return;
    GraphLandmark<G> landmark = whole_.landmarks[landmarks_.at(m.ids[1])];
    if constexpr (std::is_same_v<E, LandmarkPosition<G>>) {
      const auto sensor = part_.sensors.find(m.sensor);
      const G T_robot_sensor = sensor == part_.sensors.end() ? G::identity() : sensor->second;
      landmark.position = pose(m.ids[0]) * (T_robot_sensor * m.edge.measurement);
    }
    part_.landmarks.push_back(landmark);
  }

  const GraphFile<G>& whole_;
  GraphFile<G> part_;
  std::unordered_map<std::int64_t, std::size_t> steps_;      // at which an id is added
  std::unordered_map<std::int64_t, std::size_t> landmarks_;  // their places in the file
  std::unordered_set<std::int64_t> added_;                   // landmarks
  std::vector<std::vector<std::size_t>> edges_;              // that come at each step
};

}  // namespace landmark_detail

/// Initialises the poses and landmarks of a file by optimising its graph as it grows, every
/// `vertices_per_step` vertices: each new pose is placed by its first edge to an earlier one, each
/// landmark by its first sighting (else it is where the file has it). Odometry alone may start the
/// optimiser too far from the optimum. A part that its edges do not determine is grown further. An
/// Error, with the file unchanged, if a vertex other than the first is fixed.
template <LieGroup G>
[[nodiscard]] Result<void> start_from_growth(GraphFile<G>& file,
                                             std::size_t vertices_per_step = 20) {
  if (file.vertices.empty() || vertices_per_step == 0) return {};
  for (const std::int64_t id : file.fixed)
    if (id != file.vertices.front().id)
      return Error{ErrorCode::unsupported, "vertex " + std::to_string(id) +
                                               " is fixed: a graph grows from its first vertex"};
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
