#pragma once

// A small graph with all cases the equations must handle, and its equations as dense matrices.

#include <cmath>
#include <utility>

#include <Eigen/Core>

#include <wayfare/core/random.hpp>
#include <wayfare/graph/pose_graph.hpp>

namespace wayfare::tests {

template <class G>
TangentOf<G> random_tangent(Rng& rng, double scale) {
  TangentOf<G> d;
  for (auto& v : d) v = rng.uniform(-scale, scale);
  return d;
}

/// Five poses, two of them fixed, with edges in both directions and a doubled edge.
template <class G>
PoseGraph<G> tangle(Rng& rng) {
  PoseGraph<G> graph;
  for (int i = 0; i < 5; ++i) graph.add_pose(G::exp(random_tangent<G>(rng, 1.0)));
  for (const auto& [from, to] : {std::pair{0, 1}, {2, 1}, {3, 2}, {1, 4}, {4, 3}, {1, 4}, {0, 3}}) {
    const auto& a = graph.poses[static_cast<std::size_t>(from)];
    const auto& b = graph.poses[static_cast<std::size_t>(to)];
    const TangentOf<G> u = random_tangent<G>(rng, 1.0), v = random_tangent<G>(rng, 1.0);
    const SquareOf<G> root = SquareOf<G>::Identity() + 0.2 * u * v.transpose();
    graph.edges.push_back({from, to, (a.inverse() * b).plus(random_tangent<G>(rng, 0.3)),
                           root * root.transpose(), from > to});
  }
  graph.fixed = {0, 3};
  return graph;
}

/// Gauss-Newton matrix of ½ Σ eᵀΩe over the poses `free`, in order, from numeric Jacobians.
template <class G>
struct DenseEquations {
  static constexpr int kDof = ManifoldTraits<G>::kDof;
  Eigen::MatrixXd hessian;
  Eigen::VectorXd gradient;

  DenseEquations(PoseGraph<G> graph, const std::vector<int>& free) {
    constexpr double kStep = 1e-6;
    const auto n = static_cast<Eigen::Index>(free.size()) * kDof;
    hessian.setZero(n, n);
    gradient.setZero(n);
    for (const auto& edge : graph.edges) {
      const auto error = [&] {
        return PoseError<G>::error(edge.measurement,
                                   graph.poses[static_cast<std::size_t>(edge.from)],
                                   graph.poses[static_cast<std::size_t>(edge.to)]);
      };
      Eigen::Matrix<double, kDof, Eigen::Dynamic> j(kDof, n);
      for (Eigen::Index c = 0; c < n; ++c) {
        G& pose = graph.poses[static_cast<std::size_t>(free[static_cast<std::size_t>(c / kDof)])];
        const G kept = pose;
        const TangentOf<G> step = kStep * TangentOf<G>::Unit(c % kDof);
        pose = kept.plus(step);
        const TangentOf<G> ahead = error();
        pose = kept.plus(-step);
        j.col(c) = (ahead - error()) / (2.0 * kStep);
        pose = kept;
      }
      hessian += j.transpose() * edge.information * j;
      gradient += j.transpose() * edge.information * error();
    }
  }
};

}  // namespace wayfare::tests
