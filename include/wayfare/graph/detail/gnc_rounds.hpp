#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Eigenvalues>

#include <wayfare/core/statistics.hpp>
#include <wayfare/graph/detail/descent.hpp>
#include <wayfare/graph/edge.hpp>
#include <wayfare/graph/gnc.hpp>
#include <wayfare/graph/optimise.hpp>

namespace wayfare {

template <class... E>
struct Edges;
template <class AllVariables, class AllEdges>
class FactorGraph;

namespace detail {

/// The number of directions in which an edge has information. Not by Cholesky: its pivots are
/// rounding errors along the others.
template <class Square>
int degrees_of_freedom(const Square& information) {
  const Eigen::SelfAdjointEigenSolver<Square> eigen(information, Eigen::EigenvaluesOnly);
  const auto& values = eigen.eigenvalues();
  return static_cast<int>((values.array() > 1e-9 * values.maxCoeff()).count());
}

/// What GNC needs of a kind of graph: `start`, initial values; c² of every edge, ∞ if it is
/// trusted; u = s/c²; kStartsEqual, whether the first weights are equal; `relax`, the values that
/// solve a relaxed problem with `weights` of the edges, if there is one; `check`, whether the edges
/// whose weight is not zero determine the graph. That of pose graphs is in
/// src/graph/optimise/gnc.cpp.
template <class Graph>
class GncProblem;

template <class E>
inline constexpr bool kIsMarked = requires(const E& edge) {
  { edge.robust } -> std::convertible_to<bool>;
};
/// By its member `robust`, or else by its type, which has a kernel.
template <class E>
bool may_be_outlier(const E& edge) {
  if constexpr (kIsMarked<E>)
    return edge.robust;
  else
    return kHasKernel<E>;
}

template <class V, class... E>
class GncProblem<FactorGraph<V, Edges<E...>>> {
  static_assert(((kIsMarked<E> || kHasKernel<E>) || ...),
                "wayfare: optimise_gnc needs edges that may be outliers: give a type of edge a "
                "kernel, as Robust<E> has, or a member bool robust");

 public:
  using Graph = FactorGraph<V, Edges<E...>>;
  static constexpr bool kStartsEqual = true;

  explicit GncProblem(const Graph& graph) : graph_(graph) {}

  static Result<void> start(Graph&, const GncOptions&) { return {}; }

  [[nodiscard]] std::vector<double> thresholds(double probability) const {
    std::vector<double> of_dof(std::max({E::kDim...}) + 1), c2;
    of_dof[0] = std::numeric_limits<double>::infinity();  // trusted
    for (std::size_t n = 1; n < of_dof.size(); ++n)
      of_dof[n] = chi_square_quantile(probability, static_cast<double>(n));
    graph_.each_edge([&]<class X>(const X& edge, const auto&, const auto&...) {
      int dof = may_be_outlier(edge) ? X::kDim : 0;
      if constexpr (kHasInformation<X>)
        if (dof > 0) dof = degrees_of_freedom(edge.information);
      c2.push_back(of_dof[static_cast<std::size_t>(dof)]);
    });
    return c2;
  }
  void measure(const std::vector<double>& c2, std::vector<double>& u) const {
    std::size_t k = 0;
    graph_.each_edge([&](const auto& edge, const auto&, const auto&... x) {
      u[k] = squared_error(edge, x...) / c2[k];
      ++k;
    });
  }
  static bool relax(typename Graph::Values&, const std::vector<double>&) { return false; }
  /// Left to the factorisation.
  static Result<void> check(const std::vector<double>&) { return {}; }

 private:
  const Graph& graph_;
};

template <class Graph>
class Gnc {
 public:
  Gnc(Graph& graph, const GncOptions& options, GncReport& report)
      : graph_(graph),
        options_(options),
        report_(report),
        problem_(graph),
        c2_(problem_.thresholds(options.inlier_probability)),
        weights_(c2_.size(), 1.0),
        u_(c2_.size(), 0.0) {
    step_.set_threads(options.optimise.threads);
    step_.ignore_kernels();
  }

  Result<void> run() {
    auto done = graduate();
    return done ? settle() : done;
  }

 private:
  /// Weight of a rejected edge during the rounds, so that a variable it alone connects stays
  /// determined.
  static constexpr double kLeastWeight = 1e-9;

  Result<void> graduate();
  Result<void> settle();
  Result<void> relax(const OptimiseOptions& options);
  Result<void> solve(OptimiseOptions options);
  double measure();
  bool reweigh(double mu);
  bool cut();

  Graph& graph_;
  const GncOptions& options_;
  GncReport& report_;
  GncProblem<Graph> problem_;
  std::vector<double> c2_, weights_, u_;  // of every edge
  DampedStep<Graph, DefaultSolver<Graph::kBlock>> step_;
};

/// Follows the surrogate losses from the convex one to the final one. Only the set of inliers
/// matters, not exact values: where a relaxed problem has a single minimum it is solved instead.
template <class Graph>
Result<void> Gnc<Graph>::graduate() {
  const bool truncated = options_.loss == GncLoss::truncated_least_squares;
  OptimiseOptions coarse = options_.optimise;
  coarse.min_relative_gain = std::max(coarse.min_relative_gain, 1e-2);
  // The surrogates are convex below and above these (remarks 5 and 6).
  const auto convex = [&](double largest) {
    return truncated ? 1.0 / std::max(2.0 * largest - 1.0, 1e-9) : std::max(2.0 * largest, 1.0);
  };
  double largest = measure();
  if (!std::isfinite(largest)) return cost_overflow(graph_);
  if constexpr (GncProblem<Graph>::kStartsEqual) {
    // Values may come from the very edges that are outliers: an edge that agrees with them must not
    // outweigh the others.
    const double equal = gnc_weight(options_.loss, largest, convex(largest));
    for (std::size_t k = 0; k < weights_.size(); ++k)
      if (!std::isinf(c2_[k])) weights_[k] = std::max(equal, kLeastWeight);
    if (auto done = relax(coarse); !done) return done;
    largest = measure();
  }
  double mu = convex(largest);
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
template <class Graph>
Result<void> Gnc<Graph>::settle() {
  constexpr int kMostRounds = 10;
  report_.optimisation.structure_reused = step_.prepare(graph_);
  for (int round = 0; round < kMostRounds; ++round) {
    const bool changed = cut();
    if (round > 0 && !changed) break;
    auto done = problem_.check(weights_);
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

template <class Graph>
Result<void> Gnc<Graph>::relax(const OptimiseOptions& options) {
  typename Graph::Values x = graph_.values();
  if (problem_.relax(x, weights_)) {
    graph_.set_values(x);
    return {};
  }
  step_.prepare(graph_);
  return solve(options);
}

template <class Graph>
Result<void> Gnc<Graph>::solve(OptimiseOptions options) {
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

/// Computes u; returns the largest.
template <class Graph>
double Gnc<Graph>::measure() {
  problem_.measure(c2_, u_);
  return std::accumulate(u_.begin(), u_.end(), 0.0,
                         [](double a, double b) { return std::max(a, b); });
}

/// Whether a weight is between 0 and 1.
template <class Graph>
bool Gnc<Graph>::reweigh(double mu) {
  bool between = false;
  for (std::size_t k = 0; k < weights_.size(); ++k) {
    if (std::isinf(c2_[k])) continue;
    const double weight = gnc_weight(options_.loss, u_[k], mu);
    between = between || (weight > 0.0 && weight < 1.0);
    weights_[k] = std::max(weight, kLeastWeight);
  }
  return between;
}

/// Rounds the weights to 0 and 1; returns whether any changed.
template <class Graph>
bool Gnc<Graph>::cut() {
  bool changed = false;
  for (std::size_t k = 0; k < weights_.size(); ++k) {
    const double weight = u_[k] <= 1.0 ? 1.0 : 0.0;
    changed = changed || weight != weights_[k];
    weights_[k] = weight;
  }
  return changed;
}

}  // namespace detail

template <class Graph>
Result<GncReport> optimise_gnc(Graph& graph, const GncOptions& options) {
  GncReport report;
  const typename Graph::Values before = graph.values();
  Result<void> done;
  {
    const PhaseTimer timer(report.total_s);
    done = validate(graph);
    if (done) done = detail::GncProblem<Graph>::start(graph, options);
    if (done) done = detail::Gnc<Graph>(graph, options, report).run();
  }
  if (done) return report;
  graph.set_values(before);
  return done.error();
}

// Compiled once in wayfare::graph.
extern template Result<GncReport> optimise_gnc(PoseGraph<SE2d>&, const GncOptions&);
extern template Result<GncReport> optimise_gnc(PoseGraph<SE3d>&, const GncOptions&);

}  // namespace wayfare
