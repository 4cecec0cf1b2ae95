#pragma once

// The pieces of a trajectory and the detection of losses in a saved state.

#include <vector>

#include <wayfare/slam/detail/graph_slam/loss_detector.hpp>
#include <wayfare/slam/detail/graph_slam/node_map.hpp>

#include "slam/state_archive.hpp"

namespace wayfare::detail {

/// The fields of a LossDetector.
struct LossState {
  template <class A>
  static void fields(A& a, LossDetector& loss) {
    Gap& gap = loss.gap_;
    wayfare::fields(a, loss.matched_at_, loss.last_scan_, loss.unsure_, gap.silent_s_, gap.usual_s_,
                    gap.variance_);
  }
  static bool is_valid(const LossDetector& loss) {
    return is_count(loss.unsure_) && loss.gap_.usual_s_ >= 0.0 &&
           (loss.gap_.variance_.array() >= 0.0).all();
  }
};

template <class A>
void field(A& a, Piece& piece) {
  fields(a, piece.first, piece.part, piece.before, piece.T_before_first, piece.reach_m);
}

/// Whether pieces of `size` nodes begin one after another, the first at node 0, and belong to parts
/// that begin no later.
inline bool has_valid_pieces(const NodeMap& nodes, int size) {
  const std::vector<Piece>& pieces = nodes.all_pieces();
  if (pieces.empty() || pieces.front().first != 0) return false;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const Piece& p = pieces[i];
    if (p.first >= size || p.before < 0 || p.before > p.first || !(p.reach_m >= 0.0) ||
        !is_near(p.T_before_first) || !in(p.part, i + 1) || nodes.piece(p.part).part != p.part ||
        (i > 0 && p.first < pieces[i - 1].first))
      return false;
  }
  return true;
}

}  // namespace wayfare::detail
