#include "links.hpp"

#include <variant>

#include <wayfare/io/g2o.hpp>

bool reads_graphs() {
  const auto bad = wayfare::io::parse_g2o("VERTEX_SE2 0 1 2\n", "graph");
  const auto good = wayfare::io::parse_g2o("VERTEX_SE2 0 1 2 0.5\n", "graph");
  if (bad || !good || bad.error().line != 1) return false;
  const auto& graph = std::get<wayfare::io::GraphFile<wayfare::SE2d>>(*good);
  return graph.vertices.at(0).pose.translation() == Eigen::Vector2d(1.0, 2.0);
}
