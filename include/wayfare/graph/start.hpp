#pragma once

// Where an optimisation starts from. Least squares on poses has many local minima; which one is
// reached is decided here. Compiled in wayfare::slam for SE2d and SE3d.

#include <wayfare/core/result.hpp>
#include <wayfare/graph/pose_graph.hpp>

namespace wayfare {

enum class StartMethod {
  given,     ///< the poses stay as they are
  odometry,  ///< the chain of edges between poses that follow each other
  tree,      ///< along a spanning tree of least depth
  chordal,   ///< rotations by relaxation, then translations
};

/// Which edges a spanning tree rather takes.
enum class TreeEdges {
  any,            ///< least number of edges from a fixed pose: short chains add up little noise
  trusted_first,  ///< least number of `robust` edges on the way: those may be plain wrong
};

/// Places the free poses by the chain of edges between poses k and k + 1, from the fixed poses on
/// (pose 0 where none is named), an edge not marked `robust` before one that is. An Error where the
/// chain breaks, naming the poses. On an Error, here as below, the poses are untouched.
template <LieGroup G>
Result<void> start_from_odometry(PoseGraph<G>& graph);

/// Places the free poses along a spanning tree from the fixed poses. An Error where a pose is
/// joined to none of them.
template <LieGroup G>
Result<void> start_from_tree(PoseGraph<G>& graph, TreeEdges rather = TreeEdges::any);

/// Places the free poses wherever they were before: min Σ κ ‖R_j − R_i R_ij‖² over all matrices R,
/// each then replaced by the nearest rotation (Martinec and Pajdla 2007; Carlone et al. 2015,
/// "Initialization techniques for 3D SLAM", section III-B), then the translations that minimise
/// Σ eᵀΩe given those rotations; both linear. κ is the mean information of an edge about rotation.
/// Needs no start of its own, and ends near the global optimum where measurements are not false. An
/// Error where the edges leave a rotation or translation undetermined.
template <LieGroup G>
Result<void> start_from_chordal(PoseGraph<G>& graph);

template <LieGroup G>
Result<void> start_from(PoseGraph<G>& graph, StartMethod method) {
  switch (method) {
    case StartMethod::given:
      break;
    case StartMethod::odometry:
      return start_from_odometry(graph);
    case StartMethod::tree:
      return start_from_tree(graph);
    case StartMethod::chordal:
      return start_from_chordal(graph);
  }
  return {};
}

}  // namespace wayfare
