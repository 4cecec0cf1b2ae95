// A robot that compares each pose with the four before it: H is a band, for a solver of one's own.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include <wayfare/core/random.hpp>
#include <wayfare/graph/optimise.hpp>
#include <wayfare/graph/rank_check.hpp>

using namespace wayfare;
struct BandSolver {
  static constexpr int kBlock = 3;
  int n = 0, w = 0;   // columns of H, and numbers from the diagonal down to the end of the band
  Eigen::MatrixXd l;  // (k, j): row j + k of column j of L; columns of zeros follow
  RankCheck<3> rank;
  void analyse(const BlockSparse<3>& h) {
    n = 3 * h.columns(), w = 0;
    h.each_block([&](int r, int c, int) { w = std::max(w, 3 * (c - r) + 3); });
    rank.analyse();
  }
  FactorOutcome factorise(const BlockSparse<3>& h) {
    l.setZero(w, n + w);
    h.each_block([&](int r, int c, int b) {
      for (int k = 0; k < 9; ++k)
        if (const int i = 3 * c + k / 3, j = 3 * r + k % 3; i >= j) l(i - j, j) = h.data(b)[k];
    });
    rank.start(h);
    for (int j = 0; j < n; ++j) {
      if (rank.pivot(j, l(0, j)); !(l(0, j) > 0.0)) return rank.outcome(h, false);
      l.col(j) /= std::sqrt(l(0, j));
      for (int k = 1; k < w; ++k) l.col(j + k).head(w - k) -= l(k, j) * l.col(j).tail(w - k);
    }
    return rank.outcome(h);
  }
  void solve_in_place(Eigen::VectorXd& x) {
    x.conservativeResizeLike(Eigen::VectorXd::Zero(n + w));
    for (int j = 0; j < n; ++j) x.segment(j + 1, w - 1) -= (x[j] /= l(0, j)) * l.col(j).tail(w - 1);
    for (int j = n; j-- > 0; x[j] /= l(0, j))
      x[j] -= l.col(j).tail(w - 1).dot(x.segment(j + 1, w - 1));
    x.conservativeResize(n);
  }
};

int main() {
  PoseGraph2 graph;
  Rng rng(1);
  const SE2d step(1.0, 0.0, Angle::degrees(2));
  for (int i = 0; i < 500; ++i) {
    graph.add_pose(i == 0 ? SE2d() : graph.poses.back() * step);
    SE2d z(0.02 * rng.normal(), 0.02 * rng.normal(), Angle::degrees(0.5 * rng.normal()));
    for (int j = i - 1; j >= std::max(0, i - 4); --j)
      graph.edges.push_back({j, i, z = step * z, Eigen::Vector3d(2500, 2500, 1e4).asDiagonal()});
  }
  PoseGraph2 same = graph;
  PoseGraphOptimiser<SE2d, BandSolver> optimiser;
  if (!optimiser.optimise(graph) || !optimise(same)) return 1;
  std::printf("%.0e off the optimum; ", graph.poses[499].minus(same.poses[499]).norm());
  for (auto& edge : graph.edges) edge.information(2, 2) *= edge.to == 499 ? 0.0 : 1.0;
  if (const auto open = optimiser.optimise(graph); !open) std::puts(open.error().message.c_str());
}
