#pragma once

// Upper bounds of the relative uncertainty between poses of a graph, without a factorisation.

#include <algorithm>
#include <cstddef>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <wayfare/graph/pose_graph.hpp>

namespace wayfare {

/// The covariance of X_root⁻¹ X_k along the least uncertain chain of edges from `root` to each pose
/// k, as a right perturbation of it. It ignores all other edges, so the true covariance is smaller:
/// a safe bound for gates and search windows (Olson 2008, "Robust and efficient robotic mapping",
/// section 5.2).
struct PathUncertainty {
  /// The size of an uncertainty is var x + var y + kLever² var θ.
  static constexpr double kLever_m = 2.0;

  std::vector<Eigen::Matrix3d> covariance;  ///< per pose; undefined if not reached
  std::vector<double> size;                 ///< m²; infinite if not reached

  /// Whether a chain of edges leads to the pose.
  [[nodiscard]] bool reached(int pose) const {
    return size[static_cast<std::size_t>(pose)] < std::numeric_limits<double>::infinity();
  }
};

/// Computes the path uncertainties of a growing graph. Adjacency and edge covariances are reused
/// between searches. Poses may move between searches; edges may only be appended, and their
/// information must not change, unless `forget` is called.
class PathUncertaintyFinder {
 public:
  /// From `root` over the edges for which `usable(edge)` is true and whose information is positive
  /// definite. Dijkstra's search, O(E log V); as heading and position errors can cancel, a pose may
  /// become less uncertain than its predecessor and is then expanded again, which ends after 100
  /// expansions per pose: between poses 10⁹ m apart rounding errors alone would let it go on for
  /// ever. The result is valid until the next search.
  ///
  /// `settled(pose)` is called whenever a pose is expanded, the least uncertain first, and ends the
  /// search if it returns true: poses not expanded then have no result, or that of a chain which
  /// need not be the least uncertain.
  template <class Usable, class Settled>
  const PathUncertainty& find(const PoseGraph2& graph, int root, Usable usable, Settled settled);
  /// To all poses.
  template <class Usable>
  const PathUncertainty& find(const PoseGraph2& graph, int root, Usable usable) {
    return find(graph, root, usable, [](int) { return false; });
  }

  /// Of the last search, or so far within `settled`.
  [[nodiscard]] const PathUncertainty& result() const { return result_; }
  /// To be called before the next search where poses or edges were removed or edges have changed.
  void forget() {
    edges_ = 0;
    known_.clear();
  }

 private:
  enum class Use : char { unasked, yes, no };
  struct Link {
    int pose, edge;
  };

  void take_in_new(const PoseGraph2& graph);
  void reset_result(std::size_t poses, int root);
  void offer(int pose, const Eigen::Matrix3d& covariance);
  bool has_covariance(const PoseGraph2& graph, std::size_t edge);

  std::size_t edges_ = 0;    // in the adjacency
  std::vector<int> first_;   // of the links of each pose
  std::vector<Link> links_;  // of the poses in turn, in the order of the edges
  std::vector<Eigen::Matrix3d> edge_covariance_;
  std::vector<Use> known_;                    // whether an edge has a covariance
  std::vector<Use> use_;                      // of each edge in this search
  std::vector<std::pair<double, int>> open_;  // a heap, smallest size first
  PathUncertainty result_;
};

template <class Usable, class Settled>
const PathUncertainty& PathUncertaintyFinder::find(const PoseGraph2& graph, int root, Usable usable,
                                                   Settled settled) {
  take_in_new(graph);
  reset_result(graph.poses.size(), root);
  for (std::size_t left = 100 * graph.poses.size(); !open_.empty() && left > 0; --left) {
    const auto [size, pose] = open_.front();
    std::pop_heap(open_.begin(), open_.end(), std::greater<>());
    open_.pop_back();
    const auto at = static_cast<std::size_t>(pose);
    if (size > result_.size[at]) continue;
    if (settled(pose)) break;
    for (int i = first_[at]; i < first_[at + 1]; ++i) {
      const Link& link = links_[static_cast<std::size_t>(i)];
      const auto k = static_cast<std::size_t>(link.edge);
      const auto& e = graph.edges[k];
      if (use_[k] == Use::unasked)
        use_[k] = usable(e) && has_covariance(graph, k) ? Use::yes : Use::no;
      if (use_[k] == Use::no) continue;
      const SE2d step =
          graph.poses[at].inverse() * graph.poses[static_cast<std::size_t>(link.pose)];
      const Eigen::Matrix3d move = step.inverse().adjoint();
      Eigen::Matrix3d own = edge_covariance_[k];
      if (e.from != pose) own = move * own * move.transpose();  // the edge is traversed backwards
      offer(link.pose, move * result_.covariance[at] * move.transpose() + own);
    }
  }
  return result_;
}

/// A single search; see PathUncertaintyFinder.
template <class Usable>
[[nodiscard]] PathUncertainty path_uncertainty(const PoseGraph2& graph, int root, Usable usable) {
  return PathUncertaintyFinder().find(graph, root, usable);
}

}  // namespace wayfare
