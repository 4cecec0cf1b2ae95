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
  /// Those of `loops` whose paths may have become shorter than those found last, and at most `hops`
  /// edges long, by the accepted `edges`: over one of these no path is shorter than the ways from
  /// both ends of the loop to the nearest.
  [[nodiscard]] std::vector<int> affected(const std::vector<int>& edges,
                                          const std::vector<int>& loops, int hops);
  /// A path of at most `hops` edges; false if there is none. The same for any order of equal calls.
  bool find(int loop, int hops, LoopPath<G>& path);
  /// Number of edges of the loop's path as it was found last; kNone where none was.
  [[nodiscard]] int edges(int loop) const { return edges_[at(loop)]; }
  /// Calls shorter(loop, path) for those of `loops` that have a path of at most `hops` edges
  /// through one of `poses` which is shorter than the one found last, with the shortest.
  template <class Shorter>
  void shorten(const std::vector<int>& poses, int hops, const std::vector<int>& loops,
               Shorter shorter);
  /// The path over the chain of trusted edges.
  [[nodiscard]] LoopPath<G> along_chain(int from, int to) const;
  /// Poses along the chain, the first at the origin.
  [[nodiscard]] const std::vector<G>& odometry() const { return odometry_; }
  [[nodiscard]] const SquareOf<G>& covariance(int edge) const { return covariances_[at(edge)]; }

 private:
  /// An edge as it is traversed: to the next or the previous pose by the chain, or another.
  struct Step {
    int code = 1;  // 4 × edge + 1 + direction along the chain

    [[nodiscard]] int edge() const { return code / 4; }
    [[nodiscard]] int direction() const { return code % 4 - 1; }
    [[nodiscard]] bool continues(Step s) const {
      return direction() != 0 && direction() == s.direction();
    }
  };
  struct Link {
    int pose;
    Step step;
  };
  struct Reached {  // by a search
    int search = 0, depth = 0;
    Step step;     // to this pose
    int head = 0;  // first pose of the stretch along the chain that it ends, or itself
  };
  struct Side {  // a breadth-first search
    std::vector<Reached> poses;
    std::vector<int> queue;  // the nearest first, and room for one more
    std::size_t head = 0, tail = 0;

    [[nodiscard]] const Reached& operator[](int pose) const { return poses[at(pose)]; }
    [[nodiscard]] std::size_t layer() const { return tail - head; }
    [[nodiscard]] int head_depth(int pose) const { return (*this)[(*this)[pose].head].depth; }
  };

  void clear(Side& side) const { side.head = side.tail = 0; }
  void start(Side& side, int pose) const;
  int advance(Side& side, const Side* other) const;
  void search_from(int pose, int hops);
  int meet(int from, int to, int hops);
  [[nodiscard]] Link back(const Side& side, int pose) const;
  void trace(int from, int to, int meeting);
  int trace(int from, int to, const Side& side);
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
  std::vector<Link>
      route_;  // ends of stretches along the chain and of other edges, and the steps there
  std::vector<Link> ending_;  // of the route, from its end
  int search_ = 0;
};

template <LieGroup G>
template <class Shorter>
void LoopPaths<G>::shorten(const std::vector<int>& poses, int hops, const std::vector<int>& loops,
                           Shorter shorter) {
  std::vector<std::vector<Link>> routes(loops.size());  // empty where none is shorter
  const Side& side = sides_[0];
  for (const int pose : poses) {
    search_from(pose, hops);
    for (std::size_t i = 0; i < loops.size(); ++i) {
      const auto [from, to] = ends_[at(loops[i])];
      const Reached &a = side[from], &b = side[to];
      int& edges = edges_[at(loops[i])];
      if (a.search != search_ || b.search != search_ || a.depth + b.depth > hops ||
          a.depth + b.depth >= edges)
        continue;
      edges = trace(from, to, side);
      routes[i] = route_;
    }
  }
  LoopPath<G> path;
  for (std::size_t i = 0; i < loops.size(); ++i) {
    if (routes[i].empty()) continue;
    route_ = std::move(routes[i]);
    compose(ends_[at(loops[i])].first, path);
    shorter(loops[i], path);
  }
}

}  // namespace wayfare::detail
