#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/parallel.hpp>
#include <wayfare/slam/detail/graph_slam/local_map.hpp>
#include <wayfare/slam/detail/graph_slam/node_map.hpp>
#include <wayfare/slam/detail/loops.hpp>
#include <wayfare/slam/graph_slam.hpp>

namespace wayfare::detail {

/// Finds older nodes that share a view with the latest node, by search in likelihood fields, and
/// their poses by `Matching`.
template <class Matching>
class LoopCloser {
 public:
  LoopCloser(const GraphSlamOptions& options, const Matching& matching)
      : options_(options), matching_(matching) {}

  /// Searches at intervals of `nodes_between_loops`; returns nothing otherwise. The edges lead from
  /// older nodes to the latest.
  [[nodiscard]] Loops search(const NodeMap& nodes) {
    if (nodes.latest() - last_searched_ < options_.nodes_between_loops) return {};
    last_searched_ = nodes.latest();
    const std::vector<Candidate> tried = candidates(nodes);
    if (tried.empty()) return {};
    const PointSet seen = nodes.context(nodes.latest(), options_.loop_context_nodes);
    std::vector<LoopMatch> matches(tried.size(), std::optional<PoseEdge<SE2d>>());
    parallel_for(tried.size(), options_.threads,
                 [&](std::size_t i) { matches[i] = match(nodes, tried[i], seen); });
    return Loops(matches);
  }

  /// To be called when nodes were merged into others.
  void nodes_removed(int count) {
    last_searched_ -= count;
    uncertainty_ = {};
  }
  /// The node searched last; to be set with a restored graph.
  [[nodiscard]] int& last_searched() { return last_searched_; }

 private:
  struct Candidate {
    int node = 0;
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  // of the latest node relative to it
  };

  /// One node for each stretch of the trajectory that may share a view with the latest node: the
  /// nearest of the stretch.
  [[nodiscard]] std::vector<Candidate> candidates(const NodeMap& nodes) {
    if (!comes_near(nodes)) return {};
    const PathUncertainty& known = uncertainty_from(
        nodes.latest(), nodes.graph(), loop_kernel(options_.loop_kernel_sigmas), uncertainty_);
    std::vector<Candidate> result;
    double nearest_m = 0.0;
    int misses = 2;  // nodes since the last that qualified; a single miss does not end a stretch
    for (int k = 0; k < nodes.latest() - options_.loop_gap_nodes; ++k) {
      if (k == nodes.first_of_piece(nodes.piece_of(k))) misses = 2;
      if (!may_share_view(nodes, known, k)) {
        ++misses;
        continue;
      }
      const bool new_stretch = misses >= 2;
      misses = 0;
      if (new_stretch && static_cast<int>(result.size()) == options_.loops_per_search) break;
      if (new_stretch) result.emplace_back();
      const double distance_m = nodes.distance_m(k, nodes.latest());
      if (!new_stretch && distance_m >= nearest_m) continue;
      result.back() = {k, known.covariance[static_cast<std::size_t>(k)]};
      nearest_m = distance_m;
    }
    return result;
  }

  /// Whether the latest node is so near to one of an earlier visit that, at the largest uncertainty
  /// searched, they may share a view: else none is a candidate, at any uncertainty.
  [[nodiscard]] bool comes_near(const NodeMap& nodes) const {
    const int latest = nodes.latest();
    for (int k = 0; k < latest - options_.loop_gap_nodes; ++k)
      if (!(nodes.distance_m(k, latest) - options_.loop_reach_m >= options_.loop_overlap_m) &&
          has_travelled(nodes, k))
        return true;
    return false;
  }
  [[nodiscard]] bool has_travelled(const NodeMap& nodes, int k) const {
    return nodes.travel_m(nodes.latest()) - nodes.travel_m(k) > options_.loop_gap_travel_m;
  }

  [[nodiscard]] bool may_share_view(const NodeMap& nodes, const PathUncertainty& known,
                                    int k) const {
    if (!known.reached(k)) return false;
    const int latest = nodes.latest();
    if (!has_travelled(nodes, k)) return false;
    const double reach =
        std::min(reach_m(known.covariance[static_cast<std::size_t>(k)]), options_.loop_reach_m);
    return nodes.distance_m(k, latest) - reach < options_.loop_overlap_m;
  }

  /// The nodes of the map of a candidate: those of its piece before and after it, or, where nodes
  /// were merged and those numbered next may be elsewhere, those nearest.
  [[nodiscard]] std::vector<PlacedPoints> around(const NodeMap& nodes, int node) const {
    const int end = nodes.latest() - options_.loop_gap_nodes + 5;
    const int count = options_.loop_map_nodes;
    const int piece = nodes.piece_of(node);
    if (!nodes.merged())
      return nodes.chain(node - count,
                         std::min({node + count, end, nodes.end_of_piece(piece) - 1}));
    return nodes.around(nodes.pose(node), count * options_.node_distance_m,
                        static_cast<std::size_t>(2 * count + 1), nodes.piece(piece).part, end + 1);
  }

  /// The edge from a candidate to the latest node, if the latest scans match there.
  [[nodiscard]] LoopMatch match(const NodeMap& nodes, const Candidate& candidate,
                                const PointSet& context) const {
    std::optional<PoseEdge<SE2d>> edge;
    const int latest = nodes.latest();
    const std::vector<PlacedPoints> around = this->around(nodes, candidate.node);
    const SearchWindow window = loop_window(candidate.covariance, options_.loop_reach_m);
    const double reach = window.half_x_m;
    const double needed = reach > 1.0 ? options_.wide_loop_score : options_.loop_score;
    LocalMap map;
    map.render(around, options_.cell_m, options_.search_sigma_m);
    const Placement found = reach > 0.6
                                ? map.search_far(context, nodes.pose(latest), window, needed)
                                : map.search(context, nodes.pose(latest), window);
    if (found.score < needed) return edge;
    const auto sharp = matching_.confirm(around, nodes.points(latest), found.T_map_points, map);
    if (!sharp) return sharp.error();
    if (!*sharp) return edge;
    const SE2d& pose = (*sharp)->T_map_points;
    const Eigen::Matrix3d information =
        match_information(**sharp, pose.rotation(), 0.04, Angle::degrees(0.6).radians());
    edge = {candidate.node, latest, nodes.pose(candidate.node).inverse() * pose, information, true};
    return edge;
  }

  GraphSlamOptions options_;
  Matching matching_;
  PathUncertaintyFinder uncertainty_;
  int last_searched_ = 0;
};

}  // namespace wayfare::detail
