#include <initializer_list>

#include <wayfare/io/g2o.hpp>

#include "io/text/g2o_lines.hpp"
#include "io/text/text.hpp"

namespace wayfare::io {
namespace {

template <class Matrix>
void append_triangle(std::string& out, const Matrix& matrix, int size) {
  for (int row = 0; row < size; ++row)
    for (int column = row; column < size; ++column)
      text::append_numbers(out, {matrix(row, column)});
  out += '\n';
}

void append_tag(std::string& out, std::string_view tag, std::initializer_list<std::int64_t> ids) {
  out += tag;
  for (const std::int64_t id : ids) out.append(" ").append(std::to_string(id));
}

template <class E>
void append_measurements(std::string& out, const std::vector<GraphMeasurement<E>>& list) {
  using Line = LineOf<E>;
  for (const GraphMeasurement<E>& m : list) {
    out += Line::kTag;
    for (const std::int64_t id : m.ids) out.append(" ").append(std::to_string(id));
    if (Line::kSensor) out.append(" ").append(std::to_string(m.sensor));
    Line::append(out, m.edge);
    append_triangle(out, m.edge.information, Line::kDim);
  }
}

template <class G>
std::string format(const GraphFile<G>& graph) {
  std::string out;
  out.reserve(graph.vertices.size() * 80 + graph.edges.size() * 160);
  for (const auto& [id, pose] : graph.sensors) {
    append_tag(out, Dialect<G>::kSensor, {id});
    Dialect<G>::append(out, pose);
    out += '\n';
  }
  for (const GraphVertex<G>& vertex : graph.vertices) {
    append_tag(out, Dialect<G>::kVertex, {vertex.id});
    Dialect<G>::append(out, vertex.pose);
    out += '\n';
  }
  for (const GraphLandmark<G>& landmark : graph.landmarks) {
    append_tag(out, Dialect<G>::kLandmark, {landmark.id});
    text::append_numbers(out, landmark.position);
    out += '\n';
  }
  for (const std::int64_t id : graph.fixed) {
    append_tag(out, "FIX", {id});
    out += '\n';
  }
  for (const GraphEdge<G>& edge : graph.edges) {
    append_tag(out, Dialect<G>::kEdge, {edge.from, edge.to});
    Dialect<G>::append(out, edge.measurement);
    append_triangle(out, edge.information, G::kDof);
  }
  std::apply([&](const auto&... list) { (append_measurements(out, list), ...); },
             graph.measurements);
  return out;
}

}  // namespace

std::string format_g2o(const GraphFile<SE2d>& graph) { return format(graph); }
std::string format_g2o(const GraphFile<SE3d>& graph) { return format(graph); }

}  // namespace wayfare::io
