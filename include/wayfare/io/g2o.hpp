#pragma once

// Pose graphs as g2o text: VERTEX_SE2, EDGE_SE2, VERTEX_SE3:QUAT, EDGE_SE3:QUAT and FIX.
// A graph with a part left out is another problem, so reading is strict: the first fault refuses
// the file and names its line.

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <wayfare/core/manifold.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/io/text_file.hpp>

namespace wayfare::io {

template <class G>
struct GraphVertex {
  std::int64_t id = 0;
  G pose{};
  std::size_t line = 0;  ///< where it stood in the file, 0 where it comes from none
};

/// The pose of vertex `to` seen from vertex `from`, with the inverse of its covariance on g2o's
/// error: (x, y, θ), or translation then the vector part of the unit quaternion.
template <class G>
struct GraphEdge {
  std::int64_t from = 0;
  std::int64_t to = 0;
  G measurement{};
  SquareOf<G> information = SquareOf<G>::Identity();
  std::size_t line = 0;  ///< where it stood in the file, 0 where it comes from none
};

/// Vertices have different ids; edges join different vertices of the graph.
template <class G>
struct GraphFile {
  std::vector<GraphVertex<G>> vertices;
  std::vector<GraphEdge<G>> edges;
  std::vector<std::int64_t> fixed;  ///< ids of FIX lines

  /// Lines of kinds this reader does not know (landmarks, parameters), left out.
  std::size_t ignored_lines = 0;
  /// Information matrices brought to the nearest positive semi-definite one, where asked for.
  std::size_t projected_edges = 0;
};

using AnyGraphFile = std::variant<GraphFile<SE2d>, GraphFile<SE3d>>;

enum class IndefiniteInformation {
  refuse,   ///< the file is refused, naming edge and line
  project,  ///< negative eigenvalues become zero: the nearest semi-definite matrix (Frobenius)
};

struct G2oOptions {
  IndefiniteInformation indefinite = IndefiniteInformation::refuse;
  /// How far below zero, against the largest, an eigenvalue may be by rounding of the text.
  double eigenvalue_tolerance = 1e-6;
  ReadOptions file = {};
};

/// Errors, each with its line: malformed or non-finite numbers, a quaternion that is not a unit, an
/// information matrix that is not finite or not positive semi-definite, a vertex given twice, an
/// edge to an unknown vertex or to itself, planar and spatial lines mixed, no vertex at all.
[[nodiscard]] Result<AnyGraphFile> read_g2o(const std::string& path,
                                            const G2oOptions& options = {});
[[nodiscard]] Result<AnyGraphFile> parse_g2o(std::string_view text, const std::string& source,
                                             const G2oOptions& options = {});

/// Numbers are written so that reading them gives the same bits.
[[nodiscard]] std::string format_g2o(const GraphFile<SE2d>& graph);
[[nodiscard]] std::string format_g2o(const GraphFile<SE3d>& graph);

template <class G>
[[nodiscard]] Result<void> write_g2o(const std::string& path, const GraphFile<G>& graph,
                                     const WriteOptions& options = {}) {
  return write_file(path, format_g2o(graph), options);
}

}  // namespace wayfare::io
