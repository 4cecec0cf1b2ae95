#pragma once

// The contribution of one edge to H = Σ JᵀΩJ and g = Σ JᵀΩe.

#include <wayfare/graph/pose_graph.hpp>

namespace wayfare {

template <LieGroup G>
struct EdgeTerms {
  SquareOf<G> from, to;  ///< on the diagonal, at X_i and X_j
  SquareOf<G> between;   ///< in row X_i and column X_j
  TangentOf<G> from_gradient, to_gradient;
  double squared_error = 0.0;  ///< eᵀΩe
};

void edge_terms(const PoseEdge<SE2d>& edge, const SE2d& from, const SE2d& to, EdgeTerms<SE2d>& out);
void edge_terms(const PoseEdge<SE3d>& edge, const SE3d& from, const SE3d& to, EdgeTerms<SE3d>& out);

}  // namespace wayfare
