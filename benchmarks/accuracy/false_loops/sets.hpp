#pragma once

// Graphs with false loop closures added: reproducible by seed.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>

#include <wayfare/core/random.hpp>
#include <wayfare/core/statistics.hpp>
#include <wayfare/graph/pose_graph.hpp>

namespace wayfare::examples {

/// How the false loops of a set are drawn.
enum class FalseLoops {
  random,     ///< between any two poses
  groups_10,  ///< ten neighbouring loops that agree with each other
  groups_30,  ///< thirty
  local,      ///< between poses at most 20 steps apart
};

[[nodiscard]] inline const char* name_of(FalseLoops kind) {
  constexpr const char* kNames[] = {"random", "groups of 10", "groups of 30", "local"};
  return kNames[static_cast<int>(kind)];
}

/// Appends false loops to a graph at its optimum. A false loop claims that two poses coincide, but
/// for an offset of 0.3 m and 10° (standard deviations), with the information of a random true
/// loop. The others of a group are at its neighbours, forwards or backwards along the trajectory,
/// with the measurement that the first and the optimum imply and noise as that of the true edges.
/// Loops that agree with the optimum (eᵀΩe below its quantile at 0.9999) are drawn again.
template <LieGroup G>
class FalseLoopMaker {
 public:
  FalseLoopMaker(const PoseGraph<G>& optimum, std::uint64_t seed) : graph_(optimum), rng_(seed) {
    for (const auto& edge : graph_.edges)
      if (edge.robust) loops_.push_back(edge);
    const double freedom = kDof * (static_cast<double>(graph_.edges.size()) - graph_.size() + 1);
    noise_ = std::sqrt(std::min(1.0, chi2(graph_) / freedom));
  }

  [[nodiscard]] PoseGraph<G> with(FalseLoops kind, int count) {
    PoseGraph<G> graph = graph_;
    const int size = kind == FalseLoops::groups_10 ? 10 : kind == FalseLoops::groups_30 ? 30 : 1;
    const auto wanted = graph_.edges.size() + static_cast<std::size_t>(count);
    while (graph.edges.size() < wanted) {
      auto group = draw(kind == FalseLoops::local ? 20 : graph_.size(), size);
      group.resize(std::min(group.size(), wanted - graph.edges.size()));
      graph.edges.insert(graph.edges.end(), group.begin(), group.end());
    }
    return graph;
  }

 private:
  static constexpr int kDof = ManifoldTraits<G>::kDof;

  [[nodiscard]] const G& pose(int i) const { return graph_.poses[static_cast<std::size_t>(i)]; }
  [[nodiscard]] int below(int n) { return static_cast<int>(rng_.below(n)); }

  [[nodiscard]] TangentOf<G> normal() {
    TangentOf<G> v;
    for (int k = 0; k < kDof; ++k) v[k] = rng_.normal(0.0, 1.0);
    return v;
  }

  [[nodiscard]] G offset() {
    TangentOf<G> by = normal();
    for (int k = 0; k < kDof; ++k)
      by[k] *= k < static_cast<int>(G::Vector::RowsAtCompileTime) ? 0.3
                                                                  : 10.0 * std::numbers::pi / 180.0;
    return G::exp(by);
  }

  /// A measurement with an error of covariance noise² Ω⁻¹.
  [[nodiscard]] G noisy(const G& z, const SquareOf<G>& information) {
    const Eigen::LLT<SquareOf<G>> root(information);
    TangentOf<G> by = noise_ * normal();
    root.matrixU().solveInPlace(by);
    if constexpr (kDof == 6) by.template tail<3>() *= 2.0;  // the vector part is half the angle
    return z.plus(by);
  }

  [[nodiscard]] bool agrees(const PoseEdge<G>& edge) const {
    return squared_error(graph_, edge) < chi_square_quantile(0.9999, kDof);
  }

  /// A group of `size` loops whose first ends are at most `reach` apart; empty if it is no good.
  [[nodiscard]] std::vector<PoseEdge<G>> draw(int reach, int size) {
    const int i = below(graph_.size()), distance = 2 + below(reach - 1);
    const int j = i + distance, turn = rng_.uniform() < 0.5 ? 1 : -1;
    PoseEdge<G> edge = loops_[static_cast<std::size_t>(below(static_cast<int>(loops_.size())))];
    const G z = offset();
    std::vector<PoseEdge<G>> group;
    for (int k = 0; k < size; ++k) {
      edge.from = i + k, edge.to = j + turn * k;
      if (edge.to >= graph_.size() || edge.to < edge.from + 2) return {};
      const G from = pose(i).inverse() * pose(edge.from), to = pose(j).inverse() * pose(edge.to);
      edge.measurement = from.inverse() * z * to;
      if (k > 0) edge.measurement = noisy(edge.measurement, edge.information);
      if (agrees(edge)) return {};
      group.push_back(edge);
    }
    return group;
  }

  const PoseGraph<G>& graph_;
  Rng rng_;
  std::vector<PoseEdge<G>> loops_;
  double noise_ = 1.0;
};

}  // namespace wayfare::examples
