// Links io and what it stands on: reads a graph, optimises it, and compresses through zlib.

#include <cstdio>
#include <variant>

#include <wayfare/graph/optimise.hpp>
#include <wayfare/io/g2o.hpp>
#include <wayfare/io/map_image.hpp>

int main() {
  using namespace wayfare;
  const auto file = io::parse_g2o(
      "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\n"
      "EDGE_SE2 0 1 1.0 0 0 1 0 0 1 0 1\nEDGE_SE2 0 1 0.9 0 0 1 0 0 1 0 1\n",
      "graph");
  if (!file) return std::puts(file.error().to_string().c_str()), 1;
  auto graph = io::to_pose_graph(std::get<io::GraphFile<SE2d>>(*file));
  const auto report = optimise(graph);
  if (!report) return std::puts(report.error().to_string().c_str()), 1;
  if (!io::encode_png({1, 1, 1, {0}})) return 1;
  std::printf("poses %zu, cost %.4f\n", graph.poses.size(), report->final_chi2);
}
