#include <wayfare/graph/loop_consistency.hpp>

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include <wayfare/core/statistics.hpp>
#include <wayfare/graph/detail/validate.hpp>
#include <wayfare/graph/gnc.hpp>
#include <wayfare/graph/optimise.hpp>
#include <wayfare/graph/pose_graph.hpp>

#include "graph/consistency/growth.hpp"
#include "graph/lists.hpp"

namespace wayfare {
namespace {

using detail::at;

/// Solves with the accepted loops and corrects their set at the optimum.
template <LieGroup G>
class ConsistentSolve {
 public:
  ConsistentSolve(const PoseGraph<G>& graph, const LoopConsistencyOptions& options,
                  LoopConsistencyReport& report)
      : graph_(graph),
        growth_(graph, options),
        options_(options),
        report_(report),
        gate_(chi_square_quantile(options.inlier_probability, ManifoldTraits<G>::kDof)),
        part_{graph.poses, {}, graph.fixed, graph.labels},
        kept_(graph.edges.size(), 0) {
    options_.optimise.kernel = {};
  }

  Result<void> run();
  [[nodiscard]] bool keeps(std::size_t edge) const { return kept_[edge] != 0; }
  [[nodiscard]] const detail::LoopGrowth<G>& growth() const { return growth_; }
  [[nodiscard]] std::vector<G> take_poses() { return std::move(part_.poses); }

 private:
  void select();
  Result<void> start();
  Result<void> grow();
  bool accept_at_optimum();
  Result<void> optimise_part();
  Result<void> part_with_outliers();
  [[nodiscard]] bool all_agree() const;
  bool readmit();
  void count(OptimiseReport report);

  const PoseGraph<G>& graph_;
  detail::LoopGrowth<G> growth_;
  PoseGraphOptimiser<G> optimiser_;
  LoopConsistencyOptions options_;
  LoopConsistencyReport& report_;
  double gate_;
  PoseGraph<G> part_;       // without the rejected edges
  std::vector<char> kept_;  // of every edge
};

template <LieGroup G>
void ConsistentSolve<G>::select() {
  part_.edges.clear();
  for (std::size_t k = 0; k < kept_.size(); ++k)
    if (keeps(k)) part_.edges.push_back(graph_.edges[k]);
}

template <LieGroup G>
void ConsistentSolve<G>::count(OptimiseReport report) {
  report_.iterations += report.iterations;
  report_.optimisation = std::move(report);
}

template <LieGroup G>
Result<void> ConsistentSolve<G>::optimise_part() {
  auto solved = optimiser_.optimise(part_, options_.optimise);
  if (!solved) return solved.error();
  count(std::move(*solved));
  return {};
}

template <LieGroup G>
bool ConsistentSolve<G>::all_agree() const {
  for (const auto& edge : part_.edges)
    if (edge.robust && squared_error(part_, edge) > gate_) return false;
  return true;
}

/// Where accepted loops contradict each other.
template <LieGroup G>
Result<void> ConsistentSolve<G>::part_with_outliers() {
  GncOptions options;
  options.inlier_probability = options_.inlier_probability;
  options.optimise = options_.optimise;
  auto solved = optimise_gnc(part_, options);
  if (!solved) return solved.error();
  report_.iterations += solved->iterations - solved->optimisation.iterations;
  count(std::move(solved->optimisation));
  std::vector<std::size_t> edges;
  for (std::size_t k = 0; k < kept_.size(); ++k)
    if (keeps(k)) edges.push_back(k);
  for (const int k : solved->rejected) kept_[edges[at(k)]] = 0;
  return {};
}

/// Rejected loops that agree with the optimum.
template <LieGroup G>
bool ConsistentSolve<G>::readmit() {
  bool any = false;
  for (std::size_t k = 0; k < kept_.size(); ++k) {
    if (keeps(k) || squared_error(part_, graph_.edges[k]) > gate_) continue;
    kept_[k] = 1, any = true;
  }
  return any;
}

template <LieGroup G>
Result<void> ConsistentSolve<G>::start() {
  for (std::size_t k = 0; k < kept_.size(); ++k) kept_[k] = growth_.accepted(k) ? 1 : 0;
  select();
  auto done = start_from_chordal(part_);
  if (!done) done = start_from_tree(part_);
  return done ? optimise_part() : done;
}

template <LieGroup G>
bool ConsistentSolve<G>::accept_at_optimum() {
  constexpr std::size_t kMost = 200;  // open loops; each is a few solves
  if (growth_.open() == 0 || growth_.open() > kMost || !optimiser_.prepare_covariances(part_))
    return false;
  return growth_.accept_by([&](const PoseEdge<G>& loop) {
    const G across = part_.poses[at(loop.from)].inverse() * part_.poses[at(loop.to)];
    return detail::LoopPath<G>{across, optimiser_.relative_covariance(part_, loop.from, loop.to),
                               std::numeric_limits<double>::infinity()};
  });
}

/// Accepts loops by paths, then at the optimum.
template <LieGroup G>
Result<void> ConsistentSolve<G>::grow() {
  growth_.run();
  auto done = start();
  while (done) {
    const bool more = accept_at_optimum();
    if (more) growth_.run();
    if (!more && !growth_.accept_together()) break;
    done = start();
  }
  return done;
}

template <LieGroup G>
Result<void> ConsistentSolve<G>::run() {
  constexpr int kMostRounds = 5;
  auto done = grow();
  for (int round = 0; done && round < kMostRounds; ++round) {
    if (!all_agree()) done = part_with_outliers();
    if (!done || !readmit()) break;
    select();
    done = optimise_part();
  }
  return done;
}

Result<void> check_options(const LoopConsistencyOptions& o) {
  const auto invalid = [](const char* what) { return Error{ErrorCode::invalid, what}; };
  if (!(o.inlier_probability > 0.0 && o.inlier_probability < 1.0))
    return invalid("inlier_probability is not between 0 and 1");
  if (!(o.max_false >= 0.0)) return invalid("max_false is not a number from 0");
  if (!(o.noise_scale >= 0.0 && std::isfinite(o.noise_scale)))
    return invalid("noise_scale is not a finite number from 0");
  return {};
}

template <LieGroup G>
Result<void> run(PoseGraph<G>& graph, const LoopConsistencyOptions& options,
                 LoopConsistencyReport& report) {
  auto done = check_options(options);
  if (done) done = validate(graph);
  if (done) done = detail::check_chain(graph);
  if (!done) return done;
  ConsistentSolve<G> solve(graph, options, report);
  done = solve.run();
  const detail::LoopGrowth<G>& growth = solve.growth();
  report.noise_scale = growth.noise_scale();
  report.rounds = growth.rounds();
  if (!done) return done;
  for (std::size_t k = 0; k < graph.edges.size(); ++k) {
    if (solve.keeps(k)) continue;
    report.rejected.push_back(static_cast<int>(k));
    if (growth.undecided(k)) report.undecided.push_back(static_cast<int>(k));
  }
  graph.poses = solve.take_poses();
  return {};
}

}  // namespace

template <LieGroup G>
Result<LoopConsistencyReport> optimise_consistent_loops(PoseGraph<G>& graph,
                                                        const LoopConsistencyOptions& options) {
  LoopConsistencyReport report;
  Result<void> done;
  {
    const PhaseTimer timer(report.total_s);
    done = run(graph, options, report);
  }
  if (!done) return done.error();
  return report;
}

template Result<LoopConsistencyReport> optimise_consistent_loops(PoseGraph<SE2d>&,
                                                                 const LoopConsistencyOptions&);
template Result<LoopConsistencyReport> optimise_consistent_loops(PoseGraph<SE3d>&,
                                                                 const LoopConsistencyOptions&);

}  // namespace wayfare
