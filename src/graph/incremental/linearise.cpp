// An edge as a term of the linear system.

#include <wayfare/graph/detail/normal_equations.hpp>
#include <wayfare/graph/incremental.hpp>

namespace wayfare {

template <LieGroup G>
auto IncrementalOptimiser<G>::linearise(const PoseEdge<G>& edge) const -> IncrementalTerm<kDof> {
  EdgeTerms<G> terms;
  edge_terms(edge, origins_[index(edge.from)], origins_[index(edge.to)], terms);
  const double weight = edge.robust ? kernel_(terms.squared_error).weight : 1.0;
  IncrementalTerm<kDof> term;
  term.aa = weight * terms.from;
  term.ab = weight * terms.between;
  term.bb = weight * terms.to;
  term.ra = -weight * terms.from_gradient;
  term.rb = -weight * terms.to_gradient;
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
