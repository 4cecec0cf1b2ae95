#pragma once

#include <vector>

#include <wayfare/slam/detail/graph_slam/field_matching.hpp>
#include <wayfare/slam/detail/graph_slam/loss_detector.hpp>
#include <wayfare/slam/detail/graph_slam/node_map.hpp>
#include <wayfare/slam/detail/graph_slam/piece_joiner.hpp>
#include <wayfare/slam/submap_slam.hpp>

#include "slam/submap_slam/submap_graph.hpp"

namespace wayfare {

/// The pieces of the trajectory of submap SLAM: whether tracking is lost, and the search for joins,
/// which is that of graph SLAM.
class SubmapPieces {
 public:
  explicit SubmapPieces(const SubmapSlamOptions& options);

  /// Whether a score is that of a scan that is where its match says: as good as those of others,
  /// more after a scan that was not, less where the piece has seen little.
  [[nodiscard]] bool is_usual(double score, const SubmapGraph& map) const;
  /// Of a scan that is.
  void add_score(double score) { usual_score_ += kGain * (score - usual_score_); }

  /// A pose from which no scan reaches the map.
  [[nodiscard]] SE2d beside(const SubmapGraph& map) const;
  /// The latest node of the map begins a piece, predicted from the node before it.
  void begin(SubmapGraph& map, const SE2d& T_before_first, double reach_m);
  /// To be called after other nodes, too.
  void follow(const SubmapGraph& map);

  /// Joins the latest node's part of the map to another, where it is found in it; whether it is.
  bool join_latest(SubmapGraph& map);
  /// The same of all parts.
  bool join_all(SubmapGraph& map);
  /// Parts of few nodes that are not joined go where their motion predicts them.
  void place_small_parts(SubmapGraph& map);
  /// Poses of the map have changed.
  void moved() { joiner_.nodes_changed(); }
  /// Before the first nodes of the map are removed.
  void forget(int nodes);
  /// The first pose of each part is held in the graph, as no edge determines it.
  void hold_parts(SubmapGraph& map) const;

  [[nodiscard]] bool are_several() const { return nodes_.pieces() > 1; }
  [[nodiscard]] int first_of_latest() const {
    return are_several() ? nodes_.first_of_piece(nodes_.pieces() - 1) : 0;
  }
  /// The first node of a node's part of the map.
  [[nodiscard]] int first_of_part(int node) const {
    return are_several() ? nodes_.first_of_piece(part_of(node)) : 0;
  }
  /// Of a node: the number of the first piece in its part of the map.
  [[nodiscard]] int part_of(int node) const { return are_several() ? nodes_.part_of(node) : 0; }
  /// Whether a node is in a small part of the map, which is not drawn.
  [[nodiscard]] bool is_in_small_part(int node) const;
  void count(PieceStatistics& statistics);

  detail::LossDetector loss;

 private:
  friend struct SubmapState;  // saves and restores it

  bool join(SubmapGraph& map, const std::vector<PoseEdge<SE2d>>& edges);
  void give_poses(SubmapGraph& map) const;
  [[nodiscard]] bool has_one_part() const { return nodes_.parts().size() < 2; }

  static constexpr double kGain = 0.05;

  SubmapSlamOptions options_;
  detail::NodeMap nodes_;  // those of the map where there are several pieces; points for joins only
  detail::PieceJoiner<detail::FieldMatching> joiner_;
  double usual_score_ = 0.6;
};

}  // namespace wayfare
