#pragma once

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/parallel.hpp>
#include <wayfare/slam/detail/graph_slam/local_map.hpp>
#include <wayfare/slam/detail/graph_slam/node_map.hpp>
#include <wayfare/slam/detail/graph_slam/node_merger.hpp>
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

  /// Searches at intervals of `nodes_between_loops`, or of their travel where nodes are farther
  /// apart, and at the last node; returns nothing otherwise. The edges lead from older nodes to the
  /// latest.
  [[nodiscard]] Loops search(const NodeMap& nodes, bool is_last) {
    const int since = nodes.latest() - last_searched_;
    if (since < 1) return {};
    const double travel_m = nodes.travel_m(nodes.latest()) - nodes.travel_m(last_searched_);
    const bool is_near = travel_m < 2.0 * options_.nodes_between_loops * options_.node_distance_m;
    if (!is_last && since < options_.nodes_between_loops && is_near) return {};
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
    uncertainty_.forget();
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
    const PathUncertainty& known = uncertainty(nodes);
    if (merges_nodes(options_, nodes)) return nearest_apart(nodes, known);
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

  /// Where nodes were merged, those numbered in succession need not be neighbours: the nearest, and
  /// the next ones far from it. Others nearby would be matched to nearly the same map: their errors
  /// are the same, and all together count as if they were independent.
  [[nodiscard]] std::vector<Candidate> nearest_apart(const NodeMap& nodes,
                                                     const PathUncertainty& known) const {
    const double apart_m = 3.0 * options_.loop_map_nodes * options_.node_distance_m;
    std::vector<std::pair<double, int>> near;
    for (int k = 0; k < nodes.latest() - options_.loop_gap_nodes; ++k)
      if (may_share_view(nodes, known, k))
        near.emplace_back(nodes.distance_m(k, nodes.latest()), k);
    std::ranges::sort(near);
    std::vector<Candidate> result;
    for (const auto& [distance_m, k] : near) {
      if (static_cast<int>(result.size()) == options_.loops_per_search) break;
      if (std::ranges::all_of(result, [&, node = k](const Candidate& c) {
            return nodes.distance_m(c.node, node) > apart_m;
          }))
        result.push_back({k, known.covariance[static_cast<std::size_t>(k)]});
    }
    return result;
  }

  /// Of the paths from the latest node, as far as those that may be candidates.
  const PathUncertainty& uncertainty(const NodeMap& nodes) {
    const auto kernel = loop_kernel(options_.loop_kernel_sigmas);
    wanted_.assign(static_cast<std::size_t>(nodes.size()), false);
    std::size_t left = 0;
    for (int k = 0; k < nodes.latest() - options_.loop_gap_nodes; ++k) {
      if (!is_near(nodes, k) || !has_travelled(nodes, k)) continue;
      wanted_[static_cast<std::size_t>(k)] = true;
      ++left;
    }
    return uncertainty_from(nodes.latest(), nodes.graph(), kernel, uncertainty_, [&](int pose) {
      if (wanted_[static_cast<std::size_t>(pose)]) --left;
      wanted_[static_cast<std::size_t>(pose)] = false;
      return left == 0;
    });
  }

  /// Whether the latest node is so near to one of an earlier visit that, at the largest uncertainty
  /// searched, they may share a view: else none is a candidate, at any uncertainty.
  [[nodiscard]] bool comes_near(const NodeMap& nodes) const {
    const int latest = nodes.latest();
    for (int k = 0; k < latest - options_.loop_gap_nodes; ++k)
      if (is_near(nodes, k) && has_travelled(nodes, k)) return true;
    return false;
  }
  [[nodiscard]] bool is_near(const NodeMap& nodes, int k) const {
    return !(nodes.distance_m(k, nodes.latest()) - options_.loop_reach_m >=
             options_.loop_overlap_m);
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
    return nodes.distance_m(k, latest) - reach < options_.loop_overlap_m && looks_alike(nodes, k);
  }

  /// Whether a node and the latest look into the same direction, or around. Views into opposite
  /// directions of a corridor share little: the search moves one over the other along the walls, so
  /// that more of its points are in the map.
  [[nodiscard]] static bool looks_alike(const NodeMap& nodes, int k) {
    constexpr double kLeastCosine = 0.8, kAround = 0.1;
    const Eigen::Vector2d a = view_direction(nodes, k), b = view_direction(nodes, nodes.latest());
    const double size = a.norm() * b.norm();
    return size < kAround || a.dot(b) > kLeastCosine * size;
  }
  /// The mean direction of a node's points, in map axes; near zero for a scan all around.
  [[nodiscard]] static Eigen::Vector2d view_direction(const NodeMap& nodes, int k) {
    Eigen::Vector2f sum = Eigen::Vector2f::Zero();
    const PointSet& points = nodes.points(k);
    for (std::size_t i = 0; i < points.size(); ++i) sum += points[i].normalized();
    const double count = std::max<double>(1.0, static_cast<double>(points.size()));
    return nodes.pose(k).rotation() * Eigen::Vector2d(sum.cast<double>() / count);
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

  /// The prior of the search where nodes are merged: the covariance of the path. Along a corridor
  /// nearly all poses agree, those farther in the map a little better; without it one at the border
  /// of the window may be taken.
  [[nodiscard]] std::optional<Eigen::Matrix3d> prior(const NodeMap& nodes,
                                                     const Candidate& candidate) const {
    if (!merges_nodes(options_, nodes)) return {};
    return candidate.covariance.inverse();
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
    const auto prior = this->prior(nodes, candidate);
    LocalMap map;
    map.render(around, options_.cell_m, options_.search_sigma_m);
    const Placement found = reach > 0.6
                                ? map.search_far(context, nodes.pose(latest), window, needed, prior)
                                : map.search(context, nodes.pose(latest), window, prior);
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
  std::vector<bool> wanted_;  // of each node
  int last_searched_ = 0;
};

}  // namespace wayfare::detail
