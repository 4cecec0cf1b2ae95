#pragma once

// Graphs of poses and landmarks as g2o text, in the plane or in space, and planar ones as the lines
// ODOMETRY, LANDMARK and BR of the landmark SLAM data sets. A graph without some of its parts is
// another problem, so reading is strict: the first fault is an error with its line. Also converts
// between the graph of a file (vertices by id) and pose graphs to optimise (poses by index); with
// landmarks see landmark_graph.hpp.

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <tuple>
#include <unordered_map>
#include <variant>
#include <vector>

#include <wayfare/core/manifold.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/graph/edges.hpp>
#include <wayfare/graph/pose_graph.hpp>
#include <wayfare/io/text_file.hpp>

namespace wayfare::io {

/// A pose of a file.
template <class G>
struct GraphVertex {
  std::int64_t id = 0;   ///< in the file
  G pose{};              ///< initial value
  std::size_t line = 0;  ///< in the file, 0: not from a file
};

/// The pose of vertex `to` in the frame of vertex `from`, with the inverse of its covariance on
/// g2o's error: (x, y, θ), or translation then the vector part of the unit quaternion.
template <class G>
struct GraphEdge {
  std::int64_t from = 0;                              ///< id of a vertex
  std::int64_t to = 0;                                ///< id of another vertex
  G measurement{};                                    ///< Z
  SquareOf<G> information = SquareOf<G>::Identity();  ///< of the error
  std::size_t line = 0;                               ///< in the file, 0: not from a file
};

/// A landmark of a file.
template <class G>
struct GraphLandmark {
  std::int64_t id = 0;  ///< in the file
  /// Initial value, m.
  typename LandmarkPosition<G>::Point position = LandmarkPosition<G>::Point::Zero();
  std::size_t line = 0;  ///< in the file, 0: not from a file
};

/// Another measurement: an edge of factor graphs with the numbers of its line.
template <class E>
struct GraphMeasurement {
  std::array<std::int64_t, E::Variables::kCount> ids{};  ///< of its variables
  E edge{};                                              ///< the measurement
  /// In space, of LandmarkPosition, PoseOf and PositionOf: the id of the sensor's pose among
  /// `sensors`. It is not applied to `edge`.
  std::int64_t sensor = 0;
  std::size_t line = 0;  ///< in the file, 0: not from a file
};

/// One list for each type of edge.
template <class... E>
using MeasurementLists = std::tuple<std::vector<GraphMeasurement<E>>...>;

/// What a file may contain beside edges between poses. A BearingRange has a bearing only, as g2o
/// has lines for bearings and for ranges.
template <class G>
struct GraphMeasurements;
/// In the plane.
template <>
struct GraphMeasurements<SE2d> {
  /// One list for each type.
  using Lists = MeasurementLists<LandmarkPosition<SE2d>, BearingRange, RangeTo<SE2d>, PoseOf<SE2d>,
                                 PositionOf<SE2d>, Prior<Eigen::Vector2d>>;
};
/// In space.
template <>
struct GraphMeasurements<SE3d> {
  /// One list for each type.
  using Lists = MeasurementLists<LandmarkPosition<SE3d>, PoseOf<SE3d>, PositionOf<SE3d>,
                                 Prior<Eigen::Vector3d>>;
};

/// Vertices and landmarks have different ids; edges join different vertices of the graph.
template <class G>
struct GraphFile {
  std::vector<GraphVertex<G>> vertices;               ///< poses, in the order of the file
  std::vector<GraphEdge<G>> edges;                    ///< between poses, in the order of the file
  std::vector<std::int64_t> fixed;                    ///< ids of FIX lines
  std::vector<GraphLandmark<G>> landmarks;            ///< in the order of the file
  typename GraphMeasurements<G>::Lists measurements;  ///< other lines, type by type
  /// Poses of sensors in the frame of the robot, by id (PARAMS_SE3OFFSET); in space only.
  std::map<std::int64_t, G> sensors;

  /// Number of lines of each unknown kind, ignored.
  std::map<std::string, std::size_t> ignored;
  /// Information matrices projected to the nearest positive semi-definite one (option).
  std::size_t projected_edges = 0;

  /// The measurements of one type.
  template <class X>
  [[nodiscard]] std::vector<GraphMeasurement<X>>& all() {
    return std::get<std::vector<GraphMeasurement<X>>>(measurements);
  }
  /// The measurements of one type.
  template <class X>
  [[nodiscard]] const std::vector<GraphMeasurement<X>>& all() const {
    return std::get<std::vector<GraphMeasurement<X>>>(measurements);
  }
  /// Whether it is a pose graph and nothing else.
  [[nodiscard]] bool only_poses() const {
    return landmarks.empty() &&
           std::apply([](const auto&... list) { return (list.empty() && ...); }, measurements);
  }
};

using AnyGraphFile = std::variant<GraphFile<SE2d>, GraphFile<SE3d>>;  ///< by the kind of its lines

/// What to do with an information matrix that is not positive semi-definite.
enum class IndefiniteInformation {
  refuse,   ///< an error that names edge and line
  project,  ///< negative eigenvalues become zero: the nearest semi-definite matrix (Frobenius)
};

/// What the matrices of ODOMETRY and LANDMARK lines are; those of all other lines are information.
enum class LogMatrix {
  covariance,        ///< as in GTSAM's data sets
  information,       ///< inverse of the covariance
  root_information,  ///< upper triangular R with RᵀR = Ω, as in iSAM's files
};

/// How matrices are read.
struct G2oOptions {
  LogMatrix log_matrix = LogMatrix::covariance;  ///< of ODOMETRY and LANDMARK lines
  /// Information matrices with negative eigenvalues.
  IndefiniteInformation indefinite = IndefiniteInformation::refuse;
  /// Tolerance of negative eigenvalues due to rounding of the text, relative to the largest.
  double eigenvalue_tolerance = 1e-6;
  ReadOptions file = {};  ///< limits of the file
};

/// ODOMETRY, LANDMARK and BR lines define vertices that no line before them does: poses along the
/// odometry from the origin, a landmark where it is seen first. Errors, each with its line:
/// malformed or non-finite numbers, a quaternion not of unit length, an information matrix that is
/// not finite or not positive semi-definite, a duplicate vertex, an edge to an unknown vertex, to
/// one of the wrong kind or to itself, an unknown sensor, planar and spatial lines mixed, no vertex
/// at all.
[[nodiscard]] Result<AnyGraphFile> read_g2o(const std::string& path,
                                            const G2oOptions& options = {});
/// The same for text in memory; `source` names it in messages.
[[nodiscard]] Result<AnyGraphFile> parse_g2o(std::string_view text, const std::string& source,
                                             const G2oOptions& options = {});

/// Numbers read back to the same bits.
[[nodiscard]] std::string format_g2o(const GraphFile<SE2d>& graph);
/// Numbers read back to the same bits.
[[nodiscard]] std::string format_g2o(const GraphFile<SE3d>& graph);

/// Errors: the file exists (see WriteOptions), or cannot be written.
template <class G>
[[nodiscard]] Result<void> write_g2o(const std::string& path, const GraphFile<G>& graph,
                                     const WriteOptions& options = {}) {
  return write_file(path, format_g2o(graph), options);
}

/// The poses and the edges between them. Pose i is vertex i of the file, labelled by its id. Edges
/// between vertices that are not neighbours in the file's order are marked robust, since they may
/// be false loop closures. `file` must be as returned by read_g2o (ids known and distinct).
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

/// Copies the graph's poses to the vertices of `file`.
template <LieGroup G>
void take_poses(const PoseGraph<G>& graph, GraphFile<G>& file) {
  for (std::size_t i = 0; i < file.vertices.size() && i < graph.poses.size(); ++i) {
    file.vertices[i].pose = graph.poses[i];
  }
}

/// Converts a graph to a file with its indices as ids.
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
