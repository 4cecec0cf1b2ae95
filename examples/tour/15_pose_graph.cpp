// A pose graph in one call: a robot drives around a square by odometry that turns too much, and
// recognises its start.
#include <cstdio>
#include <vector>

#include <wayfare/graph/optimise.hpp>
#include <wayfare/graph/pose_graph.hpp>

using namespace wayfare;

int main() {
  std::vector<SE2d> truth{SE2d()};
  PoseGraph2 graph;
  graph.add_pose(SE2d());
  const Eigen::Matrix3d odometry_information = Eigen::Vector3d(2500.0, 2500.0, 5000.0).asDiagonal();
  for (int k = 1; k <= 40; ++k) {  // sides of 10 m, turns of 90 degrees
    const Angle turn = k % 10 == 0 ? 90_deg : 0_deg;
    truth.push_back(truth.back() * SE2d(1.0, 0.0, turn));
    const SE2d measured(1.0, 0.0, turn + 0.5_deg);
    const int last = graph.size() - 1;
    graph.add_pose(graph.poses[static_cast<std::size_t>(last)] * measured);
    graph.edges.push_back({last, last + 1, measured, odometry_information});
  }
  // The start, recognised: a measurement of 1 cm and 0.1 degrees.
  graph.edges.push_back({0, 40, truth[40], Eigen::Vector3d(1e4, 1e4, 3e5).asDiagonal()});

  const auto worst = [&] {
    double worst_m = 0.0;
    for (std::size_t k = 0; k < truth.size(); ++k)
      worst_m = std::max(worst_m, graph.poses[k].minus(truth[k]).head<2>().norm());
    return worst_m;
  };
  std::printf("before: %.2f m off, chi2 %.1f\n", worst(), chi2(graph));
  const auto report = optimise(graph);
  if (!report) return std::puts(report.error().message.c_str()), 1;
  std::printf("after: %.2f m off, chi2 %.1f\n", worst(), report->final_chi2);
}
