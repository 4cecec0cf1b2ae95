// A mowing robot that sees posts and maps them while it drives: a factor graph that grows and is
// solved after every step, with an edge of one's own.
#include <cstdio>
#include <vector>

#include <wayfare/core/random.hpp>
#include <wayfare/graph/edges.hpp>
#include <wayfare/graph/factor_graph.hpp>
#include <wayfare/graph/incremental.hpp>

using namespace wayfare;

struct SeenPost {
  using Variables = EdgeVariables<SE2d, Eigen::Vector2d>;
  using Jacobians = AutomaticJacobians;
  static constexpr int kDim = 2;
  Eigen::Vector2d seen_m;  // from the robot
  template <class T>
  Eigen::Matrix<T, 2, 1> error(const SE2<T>& robot, const Eigen::Matrix<T, 2, 1>& post) const {
    return (robot.inverse() * post - seen_m.cast<T>()) / T(0.05);
  }
};

int main() {
  IncrementalGraphOptimiser<
      FactorGraph<Variables<SE2d, Eigen::Vector2d>, Edges<Between<SE2d>, SeenPost>>>
      growing;
  const std::vector<Eigen::Vector2d> posts{{2, 2}, {6, 9}, {-7, 11}, {-4, 1}};
  std::vector<VariableId<Eigen::Vector2d>> ids(posts.size());

  const SE2d motion(1.0, 0.0, Angle::degrees(9));
  SE2d truth, dead_reckoning;
  auto robot = growing.add(truth, true);  // fixed
  Rng rng(1);
  int refactored = 0;
  for (int step = 0; step < 120; ++step) {
    truth = truth * motion;
    const SE2d odometry =
        motion * SE2d(0.02 * rng.normal(), 0.0, Angle::degrees(0.5 + 0.5 * rng.normal()));
    dead_reckoning = dead_reckoning * odometry;
    const auto last = *robot;
    robot = growing.add(growing[last] * odometry);
    (void)growing.add(Between<SE2d>{odometry, Eigen::Vector3d(2500, 2500, 6500).asDiagonal()}, last,
                      *robot);
    for (std::size_t i = 0; i < posts.size(); ++i) {
      Eigen::Vector2d seen = truth.inverse() * posts[i];
      if (seen.norm() > 5.0) continue;
      for (double& x : seen) x += 0.05 * rng.normal();
      if (ids[i].index < 0) ids[i] = *growing.add(Eigen::Vector2d(growing[*robot] * seen));
      (void)growing.add(SeenPost{seen}, *robot, ids[i]);
    }
    const auto report = growing.update();
    if (!report) return std::puts(report.error().message.c_str()), 1;
    refactored += report->refactored;
  }
  const auto off = [&](const SE2d& x) { return (truth.inverse() * x).translation().norm(); };
  std::printf("%d of %d columns factorised again\n", refactored, 120 * 121 / 2);
  std::printf("robot: %.2f m off, by odometry %.1f m\n", off(growing[*robot]), off(dead_reckoning));
}
