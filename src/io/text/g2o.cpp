#include <wayfare/io/g2o.hpp>

#include <algorithm>
#include <cmath>
#include <optional>
#include <unordered_set>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "io/text/lines.hpp"
#include "io/text/text.hpp"

namespace wayfare::io {
namespace {

/// The tags and pose format of planar and spatial lines.
template <class G>
struct Dialect;

template <>
struct Dialect<SE2d> {
  static constexpr std::string_view kVertex = "VERTEX_SE2";
  static constexpr std::string_view kEdge = "EDGE_SE2";
  static constexpr std::size_t kNumbers = 3;

  static std::optional<SE2d> pose(const double* v) {
    return SE2d(v[0], v[1], Angle::radians(v[2]));
  }
  static void append(std::string& out, const SE2d& pose) {
    text::append_numbers(out, {pose.x(), pose.y(), pose.heading().radians()});
  }
};

template <>
struct Dialect<SE3d> {
  static constexpr std::string_view kVertex = "VERTEX_SE3:QUAT";
  static constexpr std::string_view kEdge = "EDGE_SE3:QUAT";
  static constexpr std::size_t kNumbers = 7;

  static std::optional<SE3d> pose(const double* v) { return pose_of(v); }
  static void append(std::string& out, const SE3d& pose) {
    append_pose(out, pose.translation(), pose.rotation().quaternion());
  }
};

template <class G>
std::string edge_name(const GraphEdge<G>& edge) {
  return "edge " + std::to_string(edge.from) + " -> " + std::to_string(edge.to);
}

/// Reads the lines of one file up to the first fault.
template <class G>
class G2oReader {
 public:
  using Kind = Dialect<G>;

  G2oReader(std::string source, const G2oOptions& options)
      : source_(std::move(source)), options_(options) {}

  Result<AnyGraphFile> read(std::string_view all) {
    text::Lines lines(all);
    for (std::string_view line; lines.next(line);) {
      line_ = lines.number();
      const Result<void> done = take_line(line);
      if (!done) return done.error();
    }
    const Result<void> ids_known = check_ids();
    if (!ids_known) return ids_known.error();
    return AnyGraphFile(std::move(graph_));
  }

 private:
  Error fault(std::string message) const {
    return Error{ErrorCode::parse, std::move(message), source_, line_};
  }

  Result<void> take_line(std::string_view line) {
    text::Tokens tokens(line);
    const std::string_view tag = tokens.next();
    if (tag.empty() || tag[0] == '#') return {};
    if (tag == Kind::kVertex) return take_vertex(tokens);
    if (tag == Kind::kEdge) return take_edge(tokens);
    if (tag == "FIX") return take_fix(tokens);
    if (tag == Dialect<SE2d>::kVertex || tag == Dialect<SE2d>::kEdge ||
        tag == Dialect<SE3d>::kVertex || tag == Dialect<SE3d>::kEdge) {
      return fault(std::string(tag) + " in a graph that began with " + std::string(Kind::kVertex) +
                   ": planar and spatial lines do not mix");
    }
    for (const char c : tag)
      if (c <= 0x20 || c > 0x7e) return fault("unreadable bytes where a line's kind is expected");
    ++graph_.ignored_lines;
    return {};
  }

  /// Reads `count` finite numbers, which must end the line if `last`.
  Result<void> numbers(text::Tokens& tokens, double* values, std::size_t count, const char* what,
                       bool last) const {
    for (std::size_t i = 0; i < count; ++i) {
      const std::string_view token = tokens.next();
      if (token.empty()) {
        return fault(std::string(what) + ": expected " + std::to_string(count) +
                     " numbers, found " + std::to_string(i));
      }
      if (!text::to_number(token, values[i]))
        return fault(std::string(what) + ": not a number: '" + text::printable(token) + "'");
      if (!std::isfinite(values[i]))
        return fault(std::string(what) + ": not finite: '" + text::printable(token) + "'");
    }
    if (last && !tokens.at_end())
      return fault(std::string(what) + ": more than " + std::to_string(count) + " numbers");
    return {};
  }

  Result<void> id(text::Tokens& tokens, std::int64_t& value) const {
    const std::string_view token = tokens.next();
    if (text::to_number(token, value)) return {};
    return fault("expected a vertex id, a whole number; found '" + text::printable(token) + "'");
  }

  Result<G> pose(text::Tokens& tokens, const char* what, bool last) const {
    double v[Kind::kNumbers];
    const Result<void> done = numbers(tokens, v, Kind::kNumbers, what, last);
    if (!done) return done.error();
    const std::optional<G> value = Kind::pose(v);
    if (!value) return fault(std::string(what) + ": the quaternion does not have unit length");
    return *value;
  }

  Result<void> take_vertex(text::Tokens& tokens) {
    GraphVertex<G> vertex;
    vertex.line = line_;
    Result<void> done = id(tokens, vertex.id);
    if (!done) return done;
    const Result<G> value = pose(tokens, "vertex pose", true);
    if (!value) return value.error();
    vertex.pose = *value;
    if (!ids_.insert(vertex.id).second)
      return fault("vertex " + std::to_string(vertex.id) + " is defined twice");
    graph_.vertices.push_back(std::move(vertex));
    return {};
  }

  Result<void> take_fix(text::Tokens& tokens) {
    while (!tokens.at_end()) {
      std::int64_t value = 0;
      Result<void> done = id(tokens, value);
      if (!done) return done;
      graph_.fixed.push_back(value);
      fix_lines_.push_back(line_);
    }
    return {};
  }

  Result<void> take_edge(text::Tokens& tokens) {
    GraphEdge<G> edge;
    edge.line = line_;
    Result<void> done = id(tokens, edge.from);
    if (done) done = id(tokens, edge.to);
    if (!done) return done;
    if (edge.from == edge.to) return fault(edge_name(edge) + " connects a vertex to itself");
    const Result<G> value = pose(tokens, "edge measurement", false);
    if (!value) return value.error();
    edge.measurement = *value;
    done = information(tokens, edge);
    if (!done) return done;
    graph_.edges.push_back(std::move(edge));
    return {};
  }

  Result<void> information(text::Tokens& tokens, GraphEdge<G>& edge) {
    constexpr int kDof = G::kDof;
    double v[kDof * (kDof + 1) / 2];
    const std::string what = edge_name(edge) + ": information matrix, upper triangle";
    Result<void> done = numbers(tokens, v, std::size(v), what.c_str(), true);
    if (!done) return done;
    const double* next = v;
    for (int row = 0; row < kDof; ++row)
      for (int column = row; column < kDof; ++column)
        edge.information(row, column) = edge.information(column, row) = *next++;
    return check_information(edge);
  }

  Result<void> check_information(GraphEdge<G>& edge) {
    // Most matrices pass the cheap test; else the eigenvalues decide.
    if (edge.information.llt().info() == Eigen::Success) return {};
    const Eigen::SelfAdjointEigenSolver<SquareOf<G>> eigen(edge.information);
    if (eigen.info() != Eigen::Success)
      return fault(edge_name(edge) + ": the eigenvalues of its information matrix do not converge");
    const auto& values = eigen.eigenvalues();
    const double allowed = options_.eigenvalue_tolerance * values.cwiseAbs().maxCoeff();
    if (values.minCoeff() >= -allowed) return {};
    if (options_.indefinite == IndefiniteInformation::refuse) {
      std::string message =
          edge_name(edge) + ": its information matrix is not positive semi-definite (eigenvalue ";
      text::append_number(message, values.minCoeff());
      return Error{ErrorCode::invalid, message + ")", source_, line_};
    }
    const auto& axes = eigen.eigenvectors();
    const SquareOf<G> nearest = axes * values.cwiseMax(0.0).asDiagonal() * axes.transpose();
    if (!nearest.allFinite())
      return fault(edge_name(edge) + ": its information matrix is too large to be projected");
    edge.information = 0.5 * nearest + 0.5 * nearest.transpose();
    ++graph_.projected_edges;
    return {};
  }

  /// An edge may precede its vertices, so ids are checked at the end.
  Result<void> check_ids() {
    line_ = 0;
    if (graph_.vertices.empty()) return fault("no vertex in the file");
    for (const GraphEdge<G>& edge : graph_.edges) {
      for (const std::int64_t end : {edge.from, edge.to}) {
        line_ = edge.line;
        if (!ids_.contains(end))
          return fault(edge_name(edge) + ": no vertex " + std::to_string(end));
      }
    }
    for (std::size_t i = 0; i < graph_.fixed.size(); ++i) {
      line_ = fix_lines_[i];
      if (!ids_.contains(graph_.fixed[i]))
        return fault("FIX: no vertex " + std::to_string(graph_.fixed[i]));
    }
    return {};
  }

  std::string source_;
  G2oOptions options_;
  GraphFile<G> graph_;
  std::unordered_set<std::int64_t> ids_;
  std::vector<std::size_t> fix_lines_;
  std::size_t line_ = 0;
};

/// Decided by the first vertex or edge line.
bool is_spatial(std::string_view all) {
  text::Lines lines(all);
  for (std::string_view line; lines.next(line);) {
    const std::string_view tag = text::Tokens(line).next();
    if (tag == Dialect<SE3d>::kVertex || tag == Dialect<SE3d>::kEdge) return true;
    if (tag == Dialect<SE2d>::kVertex || tag == Dialect<SE2d>::kEdge) return false;
  }
  return false;
}

template <class G>
std::string format(const GraphFile<G>& graph) {
  std::string out;
  out.reserve(graph.vertices.size() * 80 + graph.edges.size() * 160);
  for (const GraphVertex<G>& vertex : graph.vertices) {
    out.append(Dialect<G>::kVertex).append(" ").append(std::to_string(vertex.id));
    Dialect<G>::append(out, vertex.pose);
    out += '\n';
  }
  for (const std::int64_t id : graph.fixed) out.append("FIX ").append(std::to_string(id)) += '\n';
  for (const GraphEdge<G>& edge : graph.edges) {
    out.append(Dialect<G>::kEdge).append(" ").append(std::to_string(edge.from));
    out.append(" ").append(std::to_string(edge.to));
    Dialect<G>::append(out, edge.measurement);
    for (int row = 0; row < G::kDof; ++row) {
      for (int column = row; column < G::kDof; ++column) {
        out += ' ';
        text::append_number(out, edge.information(row, column));
      }
    }
    out += '\n';
  }
  return out;
}

}  // namespace

Result<AnyGraphFile> parse_g2o(std::string_view all, const std::string& source,
                               const G2oOptions& options) {
  if (is_spatial(all)) return G2oReader<SE3d>(source, options).read(all);
  return G2oReader<SE2d>(source, options).read(all);
}

Result<AnyGraphFile> read_g2o(const std::string& path, const G2oOptions& options) {
  const Result<FileContent> content = read_file(path, options.file);
  if (!content) return content.error();
  // Part of a graph is another graph: damage is an error here.
  if (content->damage) return *content->damage;
  return parse_g2o(content->bytes, path, options);
}

std::string format_g2o(const GraphFile<SE2d>& graph) { return format(graph); }
std::string format_g2o(const GraphFile<SE3d>& graph) { return format(graph); }

}  // namespace wayfare::io
