#include <wayfare/graph/gnc.hpp>

#include <limits>
#include <optional>
#include <vector>

#include <wayfare/graph/pose_graph.hpp>

#include "graph/optimise/chordal.hpp"

namespace wayfare::detail {

template <LieGroup G>
class GncProblem<PoseGraph<G>> {
 public:
  static constexpr bool kStartsEqual = false;

  explicit GncProblem(const PoseGraph<G>& graph) : graph_(graph) {
    if (ChordalSolver<G>::check(graph)) chordal_.emplace(graph);
  }

  static Result<void> start(PoseGraph<G>& graph, const GncOptions& options) {
    return options.start_from_trusted ? start_from_tree(graph, TreeEdges::trusted_first)
                                      : Result<void>{};
  }

  [[nodiscard]] std::vector<double> thresholds(double probability) const {
    double of_dof[ManifoldTraits<G>::kDof + 1] = {};
    for (int n = 1; n <= ManifoldTraits<G>::kDof; ++n)
      of_dof[n] = chi_square_quantile(probability, n);
    std::vector<double> c2(graph_.edges.size(), std::numeric_limits<double>::infinity());
    const SquareOf<G>* last = nullptr;  // most edges have the same information as the previous one
    int dof = 0;
    for (std::size_t k = 0; k < c2.size(); ++k) {
      if (!graph_.edges[k].robust) continue;
      const SquareOf<G>& information = graph_.edges[k].information;
      if (last == nullptr || information != *last) dof = degrees_of_freedom(information);
      last = &information;
      c2[k] = of_dof[dof];
    }
    return c2;
  }

  void measure(const std::vector<double>& c2, std::vector<double>& u) const {
    for (std::size_t k = 0; k < u.size(); ++k)
      if (graph_.edges[k].robust) u[k] = squared_error(graph_, graph_.edges[k]) / c2[k];
  }

  bool relax(std::vector<G>& x, const std::vector<double>& weights) {
    if (chordal_ && chordal_->solve(x, weights)) return true;
    // The full equations can determine edges with partial rotational information, the relaxed
    // cannot.
    chordal_.reset();
    return false;
  }

  [[nodiscard]] Result<void> check(const std::vector<double>& weights) const {
    const auto passes = [&](const PoseEdge<G>& e) {
      return weights[static_cast<std::size_t>(&e - graph_.edges.data())] > 0.0;
    };
    return validate_connection(graph_, passes, " by edges that agree with the others");
  }

 private:
  const PoseGraph<G>& graph_;
  std::optional<ChordalSolver<G>> chordal_;
};

}  // namespace wayfare::detail

namespace wayfare {

template Result<GncReport> optimise_gnc(PoseGraph<SE2d>&, const GncOptions&);
template Result<GncReport> optimise_gnc(PoseGraph<SE3d>&, const GncOptions&);

}  // namespace wayfare
