// A robot that measures its distance to radio beacons at unknown places: an edge of one's own, with
// automatic Jacobians and a robust kernel, beside the library's edge of odometry.
#include <cmath>
#include <cstdio>
#include <vector>

#include <wayfare/core/random.hpp>
#include <wayfare/graph/edges.hpp>
#include <wayfare/graph/factor_graph.hpp>
#include <wayfare/graph/optimise.hpp>

using namespace wayfare;

struct RangeToBeacon {
  using Variables = EdgeVariables<SE2d, Eigen::Vector2d>;
  using Jacobians = AutomaticJacobians;
  static constexpr int kDim = 1;
  double range_m, sigma_m;
  template <class T>
  Eigen::Matrix<T, 1, 1> error(const SE2<T>& robot, const Eigen::Matrix<T, 2, 1>& beacon) const {
    const Eigen::Matrix<T, 2, 1> apart = beacon - robot.translation();
    return Eigen::Matrix<T, 1, 1>((apart.norm() - T(range_m)) / T(sigma_m));
  }
};

int main() {
  FactorGraph<Variables<SE2d, Eigen::Vector2d>, Edges<Between<SE2d>, Robust<RangeToBeacon>>> graph;
  const std::vector<Eigen::Vector2d> places{{-3, 8}, {9, 12}, {2, -4}};
  std::vector<VariableId<Eigen::Vector2d>> beacons;
  for (const auto& place : places) beacons.push_back(graph.add((0.8 * place).eval()));

  const SE2d motion(1.0, 0.0, Angle::degrees(8));
  SE2d truth;
  auto robot = graph.add(truth);
  graph.fix(robot);
  Rng rng(1);
  for (int step = 0; step < 90; ++step) {
    truth = truth * motion;
    const SE2d odometry =
        motion * SE2d(0.02 * rng.normal(), 0.0, Angle::degrees(0.5 * rng.normal()));
    const auto next = graph.add(graph[robot] * odometry);
    graph.add(Between<SE2d>{odometry, Eigen::Vector3d(2500, 2500, 13000).asDiagonal()}, robot,
              next);
    robot = next;
    for (std::size_t i = 0; i < places.size(); ++i) {
      const double echo = step % 10 == 0 ? 5.0 : 0.0;  // a reflection is longer
      const double range = (places[i] - truth.translation()).norm() + 0.1 * rng.normal() + echo;
      graph.add(Robust{RangeToBeacon{range, 0.1}, RobustKernel{RobustKernelKind::cauchy, 2.0}},
                robot, beacons[i]);
    }
  }

  GraphOptimiser<decltype(graph)> optimiser;
  const auto report = optimiser.optimise(graph);
  if (!report || !optimiser.prepare_covariances(graph)) return 1;
  for (std::size_t i = 0; i < places.size(); ++i)
    std::printf("beacon %zu: %.2f m off, sigma %.2f m\n", i, (graph[beacons[i]] - places[i]).norm(),
                std::sqrt(optimiser.covariance(beacons[i]).trace()));
  std::printf("robot: %.2f m off\n", (graph[robot].translation() - truth.translation()).norm());
}
