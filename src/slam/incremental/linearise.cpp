// One edge of a graph that is kept solved, as a term of its linear system.

#include <wayfare/graph/incremental.hpp>

namespace wayfare {

template <LieGroup G>
auto IncrementalOptimiser<G>::linearise(const PoseEdge<G>& edge) const -> IncrementalTerm<kDof> {
  const auto l = PoseError<G>::linearise(edge.measurement, origins_[index(edge.from)],
                                         origins_[index(edge.to)]);
  TangentOf<G> we = edge.information * l.error;
  const double s = l.error.dot(we);
  const double weight = edge.robust ? kernel_(s).weight : 1.0;
  SquareOf<G> wa = edge.information * l.by_from, wb = edge.information * l.by_to;
  we *= weight;
  wa *= weight;
  wb *= weight;
  IncrementalTerm<kDof> term;
  term.aa.noalias() = l.by_from.transpose() * wa;
  term.ab.noalias() = l.by_from.transpose() * wb;
  term.bb.noalias() = l.by_to.transpose() * wb;
  term.ra.noalias() = -l.by_from.transpose() * we;
  term.rb.noalias() = -l.by_to.transpose() * we;
  return term;
}

template <LieGroup G>
double IncrementalOptimiser<G>::cost_of(const PoseEdge<G>& edge) const {
  const double s = squared_error(graph_, edge);
  return edge.robust ? kernel_(s).cost : s;
}

template class IncrementalOptimiser<SE2d>;
template class IncrementalOptimiser<SE3d>;

}  // namespace wayfare
