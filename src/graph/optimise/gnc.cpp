#include <wayfare/graph/gnc.hpp>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include <Eigen/Eigenvalues>

#include <wayfare/core/statistics.hpp>
#include <wayfare/graph/detail/descent.hpp>
#include <wayfare/graph/optimise.hpp>
#include <wayfare/graph/pose_graph.hpp>

#include "graph/optimise/chordal.hpp"

namespace wayfare {
namespace {

/// The number of directions in which an edge has information. Not by Cholesky: its pivots are
/// rounding errors along the others.
template <class G>
int degrees_of_freedom(const SquareOf<G>& information) {
  const Eigen::SelfAdjointEigenSolver<SquareOf<G>> eigen(information, Eigen::EigenvaluesOnly);
  const auto& values = eigen.eigenvalues();
  return static_cast<int>((values.array() > 1e-9 * values.maxCoeff()).count());
}

/// c² of every edge.
template <class G>
std::vector<double> thresholds(const PoseGraph<G>& graph, double probability) {
  double of_dof[ManifoldTraits<G>::kDof + 1] = {};
  for (int n = 1; n <= ManifoldTraits<G>::kDof; ++n)
    of_dof[n] = chi_square_quantile(probability, n);
  std::vector<double> c2(graph.edges.size());
  const SquareOf<G>* last = nullptr;  // most edges have the same information as the previous one
  int dof = 0;
  for (std::size_t k = 0; k < c2.size(); ++k) {
    if (!graph.edges[k].robust) continue;
    const SquareOf<G>& information = graph.edges[k].information;
    if (last == nullptr || information != *last) dof = degrees_of_freedom<G>(information);
    last = &information;
    c2[k] = of_dof[dof];
  }
  return c2;
}

template <LieGroup G>
class Gnc {
 public:
  Gnc(PoseGraph<G>& graph, const GncOptions& options, GncReport& report)
      : graph_(graph),
        options_(options),
        report_(report),
        c2_(thresholds(graph, options.inlier_probability)),
        weights_(graph.edges.size(), 1.0),
        u_(graph.edges.size(), 0.0) {
    step_.set_threads(options.optimise.threads);
  }

  Result<void> run() {
    auto done = graduate();
    return done ? settle() : done;
  }

 private:
  /// Weight of a rejected edge during the rounds, so that a pose it alone connects stays
  /// determined.
  static constexpr double kLeastWeight = 1e-9;

  Result<void> graduate();
  Result<void> settle();
  Result<void> relax(const OptimiseOptions& options);
  Result<void> solve(OptimiseOptions options);
  void measure();
  bool reweigh(double mu);
  bool cut();

  PoseGraph<G>& graph_;
  const GncOptions& options_;
  GncReport& report_;
  std::vector<double> c2_, weights_, u_;  // of every edge; u = s/c², 0 if trusted
  std::optional<ChordalSolver<G>> chordal_;
  DampedStep<PoseGraph<G>, DefaultSolver<ManifoldTraits<G>::kDof>> step_;
};

/// Follows the surrogate losses from the convex one to the final one. Only the set of inliers
/// matters, not exact poses: the relaxed problem, which has a single minimum, is solved instead.
template <LieGroup G>
Result<void> Gnc<G>::graduate() {
  const bool truncated = options_.loss == GncLoss::truncated_least_squares;
  if (ChordalSolver<G>::check(graph_)) chordal_.emplace(graph_);
  OptimiseOptions coarse = options_.optimise;
  coarse.min_relative_gain = std::max(coarse.min_relative_gain, 1e-2);
  measure();
  const double largest =
      std::accumulate(u_.begin(), u_.end(), 0.0, [](double a, double b) { return std::max(a, b); });
  if (!std::isfinite(largest)) return cost_overflow(graph_);
  // The surrogates are convex below and above these (remarks 5 and 6).
  double mu = truncated ? 1.0 / std::max(2.0 * largest - 1.0, 1e-9) : std::max(2.0 * largest, 1.0);
  while (report_.rounds < options_.max_rounds) {
    const bool undecided = reweigh(mu);
    if (report_.rounds > 0 && (truncated ? !undecided : mu <= 1.0)) break;
    if (auto done = relax(coarse); !done) return done;
    measure();
    ++report_.rounds;
    mu = truncated ? mu * options_.growth : std::max(mu / options_.growth, 1.0);
  }
  return {};
}

/// Solves with the inliers until their set no longer changes.
template <LieGroup G>
Result<void> Gnc<G>::settle() {
  constexpr int kMostRounds = 10;
  report_.optimisation.structure_reused = step_.prepare(graph_);
  for (int round = 0; round < kMostRounds; ++round) {
    const bool changed = cut();
    if (round > 0 && !changed) break;
    const auto passes = [&](const PoseEdge<G>& e) {
      return weights_[static_cast<std::size_t>(&e - graph_.edges.data())] > 0.0;
    };
    auto done = validate_connection(graph_, passes, " by edges that agree with the others");
    if (done) done = solve(options_.optimise);
    if (done) done = check_determined(step_, graph_);
    if (!done) return done;
    measure();
  }
  for (std::size_t k = 0; k < weights_.size(); ++k) {
    if (weights_[k] == 0.0) report_.rejected.push_back(static_cast<int>(k));
  }
  return {};
}

template <LieGroup G>
Result<void> Gnc<G>::relax(const OptimiseOptions& options) {
  std::vector<G> x = graph_.poses;
  if (chordal_ && chordal_->solve(x, weights_)) {
    graph_.poses = std::move(x);
    return {};
  }
  // The full equations can determine edges with partial rotational information, the relaxed cannot.
  chordal_.reset();
  step_.prepare(graph_);
  return solve(options);
}

template <LieGroup G>
Result<void> Gnc<G>::solve(OptimiseOptions options) {
  options.kernel = {};
  step_.set_weights(weights_);
  OptimiseReport& report = report_.optimisation;
  report.iterations = 0;
  report.fell_back = false;
  report.history.clear();
  auto done = descend(step_, graph_, options, report);
  report_.iterations += report.iterations;
  report.initial_chi2 = report.initial_cost;
  report.final_chi2 = report.final_cost;
  return done;
}

template <LieGroup G>
void Gnc<G>::measure() {
  for (std::size_t k = 0; k < u_.size(); ++k)
    if (graph_.edges[k].robust) u_[k] = squared_error(graph_, graph_.edges[k]) / c2_[k];
}

/// Whether a weight is between 0 and 1.
template <LieGroup G>
bool Gnc<G>::reweigh(double mu) {
  bool between = false;
  for (std::size_t k = 0; k < weights_.size(); ++k) {
    if (!graph_.edges[k].robust) continue;
    const double weight = gnc_weight(options_.loss, u_[k], mu);
    between = between || (weight > 0.0 && weight < 1.0);
    weights_[k] = std::max(weight, kLeastWeight);
  }
  return between;
}

/// Rounds the weights to 0 and 1; returns whether any changed.
template <LieGroup G>
bool Gnc<G>::cut() {
  bool changed = false;
  for (std::size_t k = 0; k < weights_.size(); ++k) {
    const double weight = u_[k] <= 1.0 ? 1.0 : 0.0;
    changed = changed || weight != weights_[k];
    weights_[k] = weight;
  }
  return changed;
}

}  // namespace

template <LieGroup G>
Result<GncReport> optimise_gnc(PoseGraph<G>& graph, const GncOptions& options) {
  GncReport report;
  const std::vector<G> before = graph.poses;
  Result<void> done;
  {
    const PhaseTimer timer(report.total_s);
    done = validate(graph);
    if (done && options.start_from_trusted) done = start_from_tree(graph, TreeEdges::trusted_first);
    if (done) done = Gnc<G>(graph, options, report).run();
  }
  if (done) return report;
  graph.poses = before;
  return done.error();
}

template Result<GncReport> optimise_gnc(PoseGraph<SE2d>&, const GncOptions&);
template Result<GncReport> optimise_gnc(PoseGraph<SE3d>&, const GncOptions&);

}  // namespace wayfare
