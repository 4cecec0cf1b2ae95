#pragma once

// Graphs whose edges leave directions undetermined; dense linear algebra gives these directions.

#include <cstddef>
#include <vector>

#include <Eigen/Eigenvalues>
#include <Eigen/QR>

#include "graph/tangle.hpp"

namespace wayfare::tests {

enum class OpenShape { chain, tree, loops };

/// A random positive definite matrix with eigenvalues between 1 and 100.
template <class G>
SquareOf<G> random_information(Rng& rng) {
  SquareOf<G> m;
  for (auto& v : m.reshaped()) v = rng.uniform(-1.0, 1.0);
  // Of dynamic size, which is compiled once for all groups.
  const SquareOf<G> q = Eigen::HouseholderQR<Eigen::MatrixXd>(m).householderQ();
  TangentOf<G> d;
  for (auto& v : d) v = std::pow(10.0, rng.uniform(0.0, 2.0));
  return q * d.asDiagonal() * q.transpose();
}

/// `information` reduced to the fraction `left` along `n`.
template <class G>
SquareOf<G> silenced(const SquareOf<G>& information, const TangentOf<G>& n, double left) {
  const TangentOf<G> u = n.normalized();
  const SquareOf<G> p = SquareOf<G>::Identity() - u * u.transpose();
  const SquareOf<G> s = p * information * p + left * u * u.transpose();
  return 0.5 * (s + s.transpose());
}

/// Rigid groups of poses, each joined to an earlier one by edges without information (or with the
/// fraction `left` of it) along one direction: every group but the first moves freely along a
/// direction of its own. Groups of a chain or a tree are joined by one edge, with any direction of
/// its error; those of loops by three, with the same direction in the world. The poses fit the
/// measurements exactly.
template <class G>
PoseGraph<G> open_graph(Rng& rng, OpenShape shape, int directions, double left = 0.0) {
  constexpr int kGroup = 7, kMoves = static_cast<int>(G::Vector::RowsAtCompileTime);
  PoseGraph<G> graph;
  const auto join = [&](int from, int to) -> PoseEdge<G>& {
    const G &a = graph.poses[static_cast<std::size_t>(from)],
            &b = graph.poses[static_cast<std::size_t>(to)];
    graph.edges.push_back({from, to, a.inverse() * b, random_information<G>(rng), false});
    return graph.edges.back();
  };
  for (int group = 0; group <= directions; ++group) {
    const int first = graph.size();
    for (int i = 0; i < kGroup; ++i) {
      const G before = graph.poses.empty() ? G() : graph.poses.back();
      graph.add_pose(before * G::exp(random_tangent<G>(rng, 2.0)));
      if (i > 0) join(graph.size() - 2, graph.size() - 1);
    }
    join(first + 4, first + 1);
    if (group == 0) continue;
    const int earlier = shape == OpenShape::tree ? static_cast<int>(rng.below(group)) : group - 1;
    TangentOf<G> n = random_tangent<G>(rng, 1.0);
    if (shape != OpenShape::loops) {
      auto& edge = join(earlier * kGroup + 6, first);
      edge.information = silenced<G>(edge.information, n, left);
      continue;
    }
    for (const int i : {1, 3, 6}) {
      auto& edge = join(earlier * kGroup + i, first + 6 - i);
      const G& from = graph.poses[static_cast<std::size_t>(edge.from)];
      TangentOf<G> seen = TangentOf<G>::Zero();  // n in the frame of the edge's error
      seen.template head<kMoves>() = (from.rotation() * edge.measurement.rotation()).inverse() *
                                     typename G::Vector(n.template head<kMoves>());
      edge.information = silenced<G>(edge.information, seen, left);
    }
  }
  return graph;
}

/// Along which directions each pose can move while Σ eᵀΩe stays: a basis of the null space of JᵀΩJ
/// with J by numeric differentiation, hence good to 1e-6 or so. Pose 0 is held.
template <class G>
class NullSpace {
 public:
  explicit NullSpace(const PoseGraph<G>& graph) {
    std::vector<int> free;
    for (int i = 1; i < graph.size(); ++i) free.push_back(i);
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(
        DenseEquations<G>(graph, free).hessian);
    const auto count = (eigen.eigenvalues().array() < 1e-7).count();
    basis_ = eigen.eigenvectors().leftCols(count);
  }
  [[nodiscard]] Eigen::Index dimension() const { return basis_.cols(); }
  /// How far `direction` of `pose` is from any that a null vector moves it along.
  [[nodiscard]] double distance(int pose, const TangentOf<G>& direction) const {
    const Eigen::MatrixXd rows = basis_.middleRows((pose - 1) * G::kDof, G::kDof);
    const Eigen::VectorXd found =
        Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd>(rows).solve(direction);
    return (rows * found - direction).norm();
  }

 private:
  Eigen::MatrixXd basis_;
};

}  // namespace wayfare::tests
