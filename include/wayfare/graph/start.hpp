#pragma once

// Initial values of an optimisation, which decide the local minimum it reaches. Compiled in
// wayfare::graph for SE2d and SE3d.

#include <wayfare/core/result.hpp>
#include <wayfare/graph/pose_graph.hpp>

namespace wayfare {

enum class StartMethod {
  given,     ///< the graph's own poses
  odometry,  ///< the chain of edges between consecutive poses
  tree,      ///< along a breadth-first spanning tree
  chordal,   ///< chordal relaxation of the rotations, then translations
};

/// Which edges a spanning tree prefers.
enum class TreeEdges {
  any,            ///< fewest edges from a fixed pose: short chains accumulate little noise
  trusted_first,  ///< fewest `robust` edges on the path, as those may be outliers
};

/// Initialises the free poses along the chain of edges between poses k and k + 1, from the fixed
/// poses (pose 0 if there are none); edges that are not `robust` are preferred. An Error names the
/// poses where the chain breaks, or the pose whose coordinates overflow. On an Error, here as
/// below, the poses are unchanged.
template <LieGroup G>
Result<void> start_from_odometry(PoseGraph<G>& graph);

/// Initialises the free poses along a spanning tree from the fixed poses. An Error if a pose is
/// connected to none of them, or its coordinates overflow.
template <LieGroup G>
Result<void> start_from_tree(PoseGraph<G>& graph, TreeEdges rather = TreeEdges::any);

/// Initialises the free poses, independently of their values: min Σ κ ‖R_j − R_i R_ij‖² over all
/// matrices R, each then replaced by the nearest rotation (Martinec and Pajdla 2007; Carlone et al.
/// 2015, "Initialization techniques for 3D SLAM", section III-B), then the translations that
/// minimise Σ eᵀΩe given those rotations; both linear. κ is the mean rotational information of an
/// edge. Close to the global optimum in the absence of outliers. An Error if the edges leave a
/// rotation or translation undetermined.
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
