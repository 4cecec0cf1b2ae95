#include <cmath>
#include <iostream>
#include <variant>

#include "other.hpp"

using namespace wayfare::literals;

int main() {
  // The compiled parts are linked, not only their headers: a bad graph is refused with its line, and
  // there is nothing to match without points.
  const auto bad = wayfare::io::parse_g2o("VERTEX_SE2 0 1 2\n", "graph");
  const auto good = wayfare::io::parse_g2o("VERTEX_SE2 0 1 2 0.5\n", "graph");
  if (bad || !good || bad.error().line != 1) return 1;
  const auto& graph = std::get<wayfare::io::GraphFile<wayfare::SE2d>>(*good);
#ifndef STRANGER_WITHOUT_SLAM
  const auto match = wayfare::CorrelativeMatcher().match(wayfare::MatchGrid(), wayfare::PointSet(),
                                                         wayfare::SE2d(), wayfare::SearchWindow());
  if (match && match->has_value()) return 1;
#endif

  const wayfare::SE2d pose = turned(graph.vertices.at(0).pose, -0.5_rad);
  std::cout << bad.error().to_string() << '\n' << pose.log().transpose() << '\n';
  return std::abs(pose.heading().radians()) < 1e-12 ? 0 : 1;
}
