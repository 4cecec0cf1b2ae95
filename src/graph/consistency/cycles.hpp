#pragma once

// Cycles that loops close with paths over accepted edges.

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

#include <wayfare/graph/pose_graph.hpp>

#include "graph/lists.hpp"

namespace wayfare::detail {

/// Σ of an edge as a right perturbation of its measurement; where there is no information, very
/// large.
template <LieGroup G>
[[nodiscard]] SquareOf<G> edge_covariance(const PoseEdge<G>& edge);

/// For each pose k > 0 the trusted edge to k − 1, or −1.
template <LieGroup G>
[[nodiscard]] std::vector<int> chain_of(const PoseGraph<G>& graph);

/// A path between the ends of a loop.
template <LieGroup G>
struct LoopPath {
  G across;                // from the loop's first pose to its second
  SquareOf<G> covariance;  // of `across`, as a right perturbation
  double length = 0.0;     // m, of the translations along it
};

/// Paths of fewest edges between the ends of a graph's loops (edges marked `robust`), over the
/// accepted edges, of which there may be more and more.
template <LieGroup G>
class LoopPaths {
 public:
  static constexpr int kNone = std::numeric_limits<int>::max();

  /// `graph` must outlive it and have a chain of trusted edges. No edge is accepted.
  explicit LoopPaths(const PoseGraph<G>& graph);

  void accept(const std::vector<int>& edges);
  /// A path of at most `hops` edges; false if there is none. The same for any order of equal calls.
  bool find(int loop, int hops, LoopPath<G>& path);
  /// Number of edges of the loop's path as it was found last; kNone where none was.
  [[nodiscard]] int edges(int loop) const { return edges_[at(loop)]; }
  /// Calls shorter(loop, path) for those of `loops` that have a path of at most `hops` edges
  /// through a pose which is shorter than the one found last.
  template <class Shorter>
  void shorten(int pose, int hops, const std::vector<int>& loops, Shorter shorter);
  /// The path over the chain of trusted edges.
  [[nodiscard]] LoopPath<G> along_chain(int from, int to) const;
  /// Poses along the chain, the first at the origin.
  [[nodiscard]] const std::vector<G>& odometry() const { return odometry_; }
  [[nodiscard]] const SquareOf<G>& covariance(int edge) const { return covariances_[at(edge)]; }

 private:
  struct Link {
    int pose, edge;
  };
  struct Reached {  // by a search
    int search = 0, depth = 0;
    Link back{-1, -1};
  };
  struct Side {  // a breadth-first search
    std::vector<Reached> poses;
    std::vector<int> queue;  // the nearest first
    std::size_t head = 0;

    [[nodiscard]] const Reached& operator[](int pose) const { return poses[at(pose)]; }
  };

  void start(Side& side, int pose) const;
  int advance(Side& side, const Side* other) const;
  int meet(int from, int to, int hops);
  void trace(int from, int to, int meeting);
  void trace(int from, int to, const Side& side);
  [[nodiscard]] LoopPath<G> over(int from, const Link& link) const;
  void compose(int from, LoopPath<G>& path) const;

  const PoseGraph<G>& graph_;
  std::vector<SquareOf<G>> covariances_;
  std::vector<int> chain_;
  std::vector<G> odometry_;
  std::vector<SquareOf<G>> sums_;  // of the chain's covariances up to a pose, in the common frame
  std::vector<double> lengths_;    // of the chain up to a pose, m
  std::vector<int> accepted_;
  Lists<Link> links_;                      // from each pose over accepted edges
  std::vector<std::pair<int, int>> ends_;  // of every edge of the graph
  std::vector<int> edges_;                 // of its path
  std::array<Side, 2> sides_;
  std::vector<Link> route_;  // poses after the first, and the edges to them
  int search_ = 0;
};

template <LieGroup G>
template <class Shorter>
void LoopPaths<G>::shorten(int pose, int hops, const std::vector<int>& loops, Shorter shorter) {
  Side& side = sides_[0];
  ++search_;
  start(side, pose);
  for (int depth = 0; depth < hops && side.head < side.queue.size(); ++depth)
    advance(side, nullptr);
  LoopPath<G> path;
  for (const int k : loops) {
    const auto [from, to] = ends_[at(k)];
    const Reached &a = side[from], &b = side[to];
    if (a.search != search_ || b.search != search_ || a.depth + b.depth > hops ||
        a.depth + b.depth >= edges_[at(k)])
      continue;
    trace(from, to, side);
    edges_[at(k)] = static_cast<int>(route_.size());
    compose(from, path);
    shorter(k, path);
  }
}

}  // namespace wayfare::detail
