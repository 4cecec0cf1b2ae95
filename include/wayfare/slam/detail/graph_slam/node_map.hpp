#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <unordered_set>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <wayfare/graph/pose_graph.hpp>
#include <wayfare/map/likelihood_field.hpp>
#include <wayfare/sensors/point_set.hpp>

namespace wayfare::detail {

/// What was seen from a node.
struct NodeView {
  PointSet points;
  double travel_m = 0.0;
};

/// Nodes in succession, each joined to the one before.
struct Piece {
  int first = 0;         ///< node
  int part = 0;          ///< first piece of its part of the map
  int before = 0;        ///< node from which the first one's pose is predicted
  SE2d T_before_first;   ///< the prediction
  double reach_m = 0.0;  ///< how far off it may be; 0 if it is not known
};

/// The nodes: a pose graph, and for each pose the points seen from it. Indices start at 0; the
/// latest is last. They form pieces of the trajectory: a new one begins where tracking was lost.
/// Pieces joined by loops share a part of the map.
class NodeMap {
 public:
  [[nodiscard]] int size() const { return graph_.size(); }
  [[nodiscard]] int latest() const { return size() - 1; }
  [[nodiscard]] const SE2d& pose(int k) const { return graph_.poses[static_cast<std::size_t>(k)]; }
  [[nodiscard]] const PointSet& points(int k) const { return view(k).points; }  ///< base frame
  /// Path length from the first node, by the poses at the time the nodes were added.
  [[nodiscard]] double travel_m(int k) const { return view(k).travel_m; }
  [[nodiscard]] double distance_m(int a, int b) const {
    return (pose(a).translation() - pose(b).translation()).norm();
  }

  [[nodiscard]] const PoseGraph2& graph() const { return graph_; }
  [[nodiscard]] PoseGraph2& graph() { return graph_; }
  /// One for each pose.
  [[nodiscard]] std::vector<NodeView>& views() { return views_; }
  /// In order; each has a node at the time it is added.
  [[nodiscard]] std::vector<Piece>& all_pieces() { return pieces_; }
  [[nodiscard]] const std::vector<Piece>& all_pieces() const { return pieces_; }
  [[nodiscard]] const Piece& piece(int i) const { return pieces_[static_cast<std::size_t>(i)]; }
  /// Possible edges between parts of the map, found but not yet confirmed.
  [[nodiscard]] std::vector<PoseEdge<SE2d>>& possible_joins() { return possible_joins_; }
  [[nodiscard]] const std::vector<PoseEdge<SE2d>>& possible_joins() const {
    return possible_joins_;
  }

  /// The first node of a piece; `reach_m` of the prediction from the node before.
  void start(const SE2d& pose, const PointSet& points, const SE2d& T_before_first = {},
             double reach_m = 0.0) {
    const int before = std::max(latest(), 0);
    views_.push_back({points, size() == 0 ? 0.0 : travel_m(before)});
    const int first = graph_.add_pose(pose);
    pieces_.push_back({first, pieces(), before, T_before_first, reach_m});
    hold_parts();
  }
  /// A node joined to the latest by the relative pose.
  void append(const SE2d& pose, const PointSet& points, const Eigen::Matrix3d& information) {
    const int before = latest();
    const SE2d step = this->pose(before).inverse() * pose;
    views_.push_back({points, travel_m(before) + step.translation().norm()});
    graph_.edges.push_back({before, graph_.add_pose(pose), step, information, false});
  }

  /// Removes node k, to which no edge may lead; the numbers of later ones decrease.
  void erase(int k) {
    graph_.poses.erase(graph_.poses.begin() + k);
    views_.erase(views_.begin() + k);
    const auto leads_to_it = [&](const PoseEdge<SE2d>& e) { return e.from == k || e.to == k; };
    std::erase_if(possible_joins_, leads_to_it);
    for (auto* edges : {&graph_.edges, &possible_joins_})
      for (PoseEdge<SE2d>& e : *edges) {
        e.from -= e.from > k ? 1 : 0;
        e.to -= e.to > k ? 1 : 0;
      }
    for (Piece& piece : pieces_) {
      if (piece.before == k) piece.reach_m = 0.0;
      piece.first -= piece.first > k ? 1 : 0;
      piece.before -= piece.before >= k && k > 0 ? 1 : 0;
    }
    merged_ = true;
    hold_parts();
  }

  /// Removes the first nodes, and pieces that have no others.
  void forget(int nodes) {
    std::vector<Piece> kept;
    std::vector<int> first_of_part(pieces_.size(), -1);  // in `kept`
    for (int i = 0; i < pieces(); ++i) {
      if (end_of_piece(i) <= nodes) continue;
      Piece p = piece(i);
      int& part = first_of_part[static_cast<std::size_t>(p.part)];
      if (part < 0) part = static_cast<int>(kept.size());
      p.part = part;
      p.first = std::max(0, p.first - nodes);
      if (p.before < nodes) p.reach_m = 0.0;
      p.before = std::max(0, p.before - nodes);
      kept.push_back(p);
    }
    pieces_ = std::move(kept);
    graph_.poses.erase(graph_.poses.begin(), graph_.poses.begin() + nodes);
    views_.erase(views_.begin(), views_.begin() + nodes);
    for (auto* edges : {&graph_.edges, &possible_joins_}) {
      std::erase_if(*edges, [&](const auto& e) { return std::min(e.from, e.to) < nodes; });
      for (PoseEdge<SE2d>& e : *edges) {
        e.from -= nodes;
        e.to -= nodes;
      }
    }
    hold_parts();
  }

  [[nodiscard]] int pieces() const { return static_cast<int>(pieces_.size()); }
  [[nodiscard]] int first_of_piece(int i) const { return piece(i).first; }
  /// After the last node of a piece.
  [[nodiscard]] int end_of_piece(int i) const {
    return i + 1 < pieces() ? first_of_piece(i + 1) : size();
  }
  /// Of a node.
  [[nodiscard]] int piece_of(int k) const {
    int i = pieces() - 1;
    while (first_of_piece(i) > k) --i;
    return i;
  }
  /// Of a node: the number of the first piece in its part of the map.
  [[nodiscard]] int part_of(int k) const { return piece(piece_of(k)).part; }
  /// The first pieces of all parts.
  [[nodiscard]] std::vector<int> parts() const {
    std::vector<int> result;
    for (int i = 0; i < pieces(); ++i)
      if (piece(i).part == i) result.push_back(i);
    return result;
  }
  /// All nodes of a part, in order.
  [[nodiscard]] std::vector<int> nodes_of_part(int part) const {
    std::vector<int> result;
    for (int i = 0; i < pieces(); ++i)
      for (int k = first_of_piece(i); piece(i).part == part && k < end_of_piece(i); ++k)
        result.push_back(k);
    return result;
  }
  /// Moves the later part by its edges to the earlier one, of which the first counts, and makes
  /// them one.
  void join(const std::vector<PoseEdge<SE2d>>& edges) {
    const PoseEdge<SE2d>& e = edges.front();
    const int to = part_of(e.to), from = part_of(e.from);
    const SE2d T_from_to = pose(e.from) * e.measurement * pose(e.to).inverse();
    move_part(std::max(from, to), to > from ? T_from_to : T_from_to.inverse());
    const auto is_of_them = [&](const PoseEdge<SE2d>& p) {
      return part_of(p.to) == to || part_of(p.to) == from;
    };
    std::erase_if(possible_joins_, is_of_them);
    for (Piece& piece : pieces_)
      if (piece.part == std::max(from, to)) piece.part = std::min(from, to);
    graph_.edges.insert(graph_.edges.end(), edges.begin(), edges.end());
    hold_parts();
  }
  void move_part(int part, const SE2d& by) {
    for (const int k : nodes_of_part(part)) {
      SE2d& pose = graph_.poses[static_cast<std::size_t>(k)];
      pose = by * pose;
    }
  }
  /// Whether nodes were merged into others: consecutive ones need not have been passed in a row.
  [[nodiscard]] bool& merged() { return merged_; }
  [[nodiscard]] bool merged() const { return merged_; }

  /// The points of a node and `before` nodes of its piece before it in its frame, one per 10 cm
  /// cell: a larger and less ambiguous view than a single scan.
  [[nodiscard]] PointSet context(int of, int before) const {
    constexpr double kCell_m = 0.1;
    PointSet context;
    std::unordered_set<std::int64_t> taken;
    for (int k = of; k >= std::max(first_of_piece(piece_of(of)), of - before); --k) {
      const SE2d T_of_node = pose(of).inverse() * pose(k);
      const PointSet& seen = points(k);
      for (std::size_t i = 0; i < seen.size(); ++i) {
        const Eigen::Vector2d p = T_of_node * seen[i].cast<double>();
        const auto x = static_cast<std::int64_t>(std::floor(p.x() / kCell_m));
        const auto y = static_cast<std::int64_t>(std::floor(p.y() / kCell_m));
        if (taken.insert((x << 32) ^ (y & 0xffffffff)).second) context.push_back(p.cast<float>());
      }
    }
    return context;
  }

  /// Nodes first..last of the last one's piece, as far as they exist, within `radius_m` of the last
  /// of them.
  [[nodiscard]] std::vector<PlacedPoints> chain(
      int first, int last, double radius_m = std::numeric_limits<double>::infinity()) const {
    std::vector<PlacedPoints> result;
    const int end = std::min(last, latest());
    for (int k = std::max(first, first_of_piece(piece_of(end))); k <= end; ++k)
      if (distance_m(k, end) < radius_m) result.push_back({&points(k), pose(k)});
    return result;
  }
  /// The `most` of a part's nodes before `end` nearest to a pose, within `radius_m`.
  [[nodiscard]] std::vector<PlacedPoints> around(const SE2d& place, double radius_m,
                                                 std::size_t most, int part,
                                                 int end = std::numeric_limits<int>::max()) const {
    std::vector<std::pair<double, int>> near;
    for (const int k : nodes_of_part(part)) {
      const double d = (pose(k).translation() - place.translation()).norm();
      if (k < end && d < radius_m) near.emplace_back(d, k);
    }
    std::sort(near.begin(), near.end());
    near.resize(std::min(near.size(), most));
    std::vector<PlacedPoints> result;
    for (const auto& [d, k] : near) result.push_back({&points(k), pose(k)});
    return result;
  }

  /// Of a part.
  [[nodiscard]] int nearest(const SE2d& place, int part) const {
    const auto away = [&](int k) {
      return (pose(k).translation() - place.translation()).squaredNorm();
    };
    const std::vector<int> all = nodes_of_part(part);
    return *std::min_element(all.begin(), all.end(),
                             [&](int a, int b) { return away(a) < away(b); });
  }

  /// The first pose of each part is held, as no edge determines it.
  void hold_parts() {
    graph_.fixed.clear();
    const std::vector<int> all = parts();
    for (std::size_t i = 0; all.size() > 1 && i < all.size(); ++i)
      graph_.fixed.push_back(first_of_piece(all[i]));
  }

 private:
  [[nodiscard]] const NodeView& view(int k) const { return views_[static_cast<std::size_t>(k)]; }

  PoseGraph2 graph_;
  std::vector<NodeView> views_;  // one per pose
  bool merged_ = false;
  std::vector<Piece> pieces_;
  std::vector<PoseEdge<SE2d>> possible_joins_;
};

}  // namespace wayfare::detail
