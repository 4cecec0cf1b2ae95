#pragma once

// Cycles that loops close with paths over accepted edges.

#include <array>
#include <cstddef>
#include <vector>

#include <wayfare/graph/pose_graph.hpp>

namespace wayfare::detail {

/// Σ of an edge as a right perturbation of its measurement; where there is no information, very
/// large.
template <LieGroup G>
[[nodiscard]] SquareOf<G> edge_covariance(const PoseEdge<G>& edge);

/// A path between the ends of a loop.
template <LieGroup G>
struct LoopPath {
  G across;                // from the loop's first pose to its second
  SquareOf<G> covariance;  // of `across`, as a right perturbation
  double length = 0.0;     // m, of the translations along it
};

/// Paths of fewest edges over the accepted edges of a graph.
template <LieGroup G>
class LoopPaths {
 public:
  /// `graph` must outlive it. No edge is accepted.
  explicit LoopPaths(const PoseGraph<G>& graph);

  void accept(int edge);
  /// Of at most `hops` edges; false if there is none. The same for any order of equal calls.
  bool find(const PoseEdge<G>& loop, int hops, LoopPath<G>& path);
  [[nodiscard]] const SquareOf<G>& covariance(int edge) const {
    return covariances_[static_cast<std::size_t>(edge)];
  }

 private:
  struct Link {
    int pose, edge;
  };
  struct Side {  // of the search from both ends
    std::vector<int> seen;
    std::vector<Link> back;
    std::vector<int> queue;
    std::size_t head = 0;
  };

  void start(Side& side, int pose) const;
  int advance(Side& side, const Side& other);
  int meet(int from, int to, int hops);
  void trace(int from, int to, int meeting);
  void compose(int from, LoopPath<G>& path) const;

  const PoseGraph<G>& graph_;
  std::vector<SquareOf<G>> covariances_;
  std::vector<std::vector<Link>> links_;
  std::array<Side, 2> sides_;
  std::vector<Link> route_;  // poses after the first, and the edges to them
  int search_ = 0;
};

}  // namespace wayfare::detail
