#pragma once

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

#include <wayfare/core/result.hpp>
#include <wayfare/io/g2o.hpp>

namespace wayfare::io::landmark_detail {

/// Where a measurement from `pose` puts its landmark.
template <LieGroup G>
[[nodiscard]] typename LandmarkPosition<G>::Point seen_at(
    const GraphFile<G>& file, const G& pose, const GraphMeasurement<LandmarkPosition<G>>& m) {
  const auto sensor = file.sensors.find(m.sensor);
  const G T_robot_sensor = sensor == file.sensors.end() ? G::identity() : sensor->second;
  return pose * (T_robot_sensor * m.edge.measurement);
}

/// A file's graph in the order of its vertices: a landmark comes with the first vertex it is
/// measured from, an edge or a measurement with the last of its ends.
template <LieGroup G>
class Growth {
 public:
  /// An Error if another vertex than the first is fixed.
  [[nodiscard]] static Result<void> check(const GraphFile<G>& file) {
    for (const std::int64_t id : file.fixed)
      if (id != file.vertices.front().id)
        return Error{ErrorCode::unsupported, "vertex " + std::to_string(id) +
                                                 " is fixed: a graph grows from its first vertex"};
    return {};
  }

  explicit Growth(const GraphFile<G>& whole)
      : whole_(whole), edges_(whole.vertices.size()), measurements_(whole.vertices.size()) {
    part_.sensors = whole.sensors;
    for (std::size_t i = 0; i < whole.vertices.size(); ++i) steps_.emplace(whole.vertices[i].id, i);
    for (std::size_t i = 0; i < whole.landmarks.size(); ++i) {
      steps_.emplace(whole.landmarks[i].id, kNever);
      landmarks_.emplace(whole.landmarks[i].id, i);
    }
    each_list([&](auto, const auto& list) {
      for (const auto& m : list) {
        std::size_t& last = steps_.at(m.ids.back());
        if (landmarks_.contains(m.ids.back())) last = std::min(last, steps_.at(m.ids.front()));
      }
    });
    each_list([&](auto kind, const auto& list) {
      for (std::size_t k = 0; k < list.size(); ++k) {
        const std::size_t step =
            std::max(steps_.at(list[k].ids.front()), steps_.at(list[k].ids.back()));
        if (step != kNever) measurements_[step][kind].push_back(k);
      }
    });
    for (std::size_t k = 0; k < whole.edges.size(); ++k)
      edges_[std::max(steps_.at(whole.edges[k].from), steps_.at(whole.edges[k].to))].push_back(k);
  }

  /// Adds vertex `step` and the edges that come with it.
  void add_vertex(std::size_t step) {
    GraphVertex<G> vertex = whole_.vertices[step];
    bool placed = step == 0;
    for (const std::size_t k : edges_[step]) {
      const GraphEdge<G>& edge = whole_.edges[k];
      if (!placed && edge.to == vertex.id)
        vertex.pose = pose(edge.from) * edge.measurement, placed = true;
      else if (!placed)
        vertex.pose = pose(edge.to) * edge.measurement.inverse(), placed = true;
      part_.edges.push_back(edge);
    }
    part_.vertices.push_back(vertex);
  }

  /// Adds what is measured with the vertices [first, end), in the order of the file.
  void add_measurements(std::size_t first, std::size_t end) {
    each_list([&]<class E>(auto kind, const std::vector<GraphMeasurement<E>>& list) {
      std::vector<std::size_t> numbers;
      for (std::size_t step = first; step < end; ++step)
        numbers.insert(numbers.end(), measurements_[step][kind].begin(),
                       measurements_[step][kind].end());
      std::sort(numbers.begin(), numbers.end());
      for (const std::size_t k : numbers) {
        if constexpr (E::Variables::kCount == 2) add_landmark(list[k]);
        part_.template all<E>().push_back(list[k]);
      }
    });
  }

  /// A landmark that does not come with any vertex, or null.
  [[nodiscard]] const GraphLandmark<G>* never_seen() const {
    for (const auto& landmark : whole_.landmarks)
      if (steps_.at(landmark.id) == kNever) return &landmark;
    return nullptr;
  }

  GraphFile<G>& part() { return part_; }
  /// The vertices and landmarks of the part in the order of the whole.
  void copy_to(GraphFile<G>& file) const {
    file.vertices = part_.vertices;
    for (const auto& landmark : part_.landmarks)
      file.landmarks[landmarks_.at(landmark.id)].position = landmark.position;
  }

 private:
  using Lists = typename GraphMeasurements<G>::Lists;
  static constexpr std::size_t kKinds = std::tuple_size_v<Lists>;
  static constexpr std::size_t kNever = std::numeric_limits<std::size_t>::max();

  [[nodiscard]] const G& pose(std::int64_t id) const { return part_.vertices[steps_.at(id)].pose; }
  /// visit(kind, list), for every kind of measurement.
  template <class Visit>
  void each_list(const Visit& visit) const {
    std::size_t kind = 0;
    std::apply([&](const auto&... list) { (visit(kind++, list), ...); }, whole_.measurements);
  }
  template <class E>
  void add_landmark(const GraphMeasurement<E>& m) {
    if (!added_.emplace(m.ids[1]).second) return;
    GraphLandmark<G> landmark = whole_.landmarks[landmarks_.at(m.ids[1])];
    if constexpr (std::is_same_v<E, LandmarkPosition<G>>)
      landmark.position = seen_at(part_, pose(m.ids[0]), m);
    part_.landmarks.push_back(landmark);
  }

  const GraphFile<G>& whole_;
  GraphFile<G> part_;
  std::unordered_map<std::int64_t, std::size_t> steps_;      // at which an id is added
  std::unordered_map<std::int64_t, std::size_t> landmarks_;  // their places in the file
  std::unordered_set<std::int64_t> added_;                   // landmarks
  std::vector<std::vector<std::size_t>> edges_;              // that come at each step
  std::vector<std::array<std::vector<std::size_t>, kKinds>> measurements_;  // of each kind
};

}  // namespace wayfare::io::landmark_detail
