#pragma once

// Options of an optimisation and what it reports.

#include <functional>
#include <string>
#include <vector>

#include <wayfare/core/levenberg_marquardt.hpp>
#include <wayfare/core/manifold.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/graph/pose_graph.hpp>
#include <wayfare/graph/robust_kernel.hpp>

namespace wayfare {

/// How steps are computed.
enum class OptimiseMethod {
  /// Full steps, of which a few may raise the cost; falls back to Levenberg-Marquardt, from the
  /// lowest cost, where it does not fall again.
  gauss_newton,
  levenberg_marquardt,  ///< damped steps (Madsen et al. 2004)
};

/// One linear system solved.
struct IterationRecord {
  double cost = 0.0;      ///< Σ ρ(eᵀΩe) after the step, or the lowest so far if it is above that
  double damping = 0.0;   ///< λ of the step; 0 for Gauss-Newton
  double max_step = 0.0;  ///< largest component of the step (m or rad)
  bool accepted = true;   ///< lowered the cost
};

/// Method, loss, limits and threads of an optimisation.
struct OptimiseOptions {
  OptimiseMethod method = OptimiseMethod::gauss_newton;  ///< how steps are computed
  /// Of a pose graph's edges marked `robust`; those of a factor graph have their own.
  RobustKernel kernel{};
  int max_iterations = 100;  ///< maximum number of linear systems solved
  /// Converged if a step lowers the cost by less than this fraction of it (smaller: more accurate)
  double min_relative_gain = 1e-6;
  /// or by less than this (the cost has no unit).
  double min_absolute_gain = 1e-9;
  /// Full steps in a row with a cost above the lowest, before falling back (gauss_newton). More:
  /// some graphs converge in fewer steps, those that fall back take longer. 0: none may raise it.
  int max_rises = 2;
  double initial_damping = 1e-4;  ///< λ₀, relative to H's diagonal; larger: shorter first steps
  double max_damping = 1e12;      ///< stops if λ would exceed this
  /// Threads of the factorisation, if the solver supports them (ThreadedSolver) and the graph is
  /// large. More: faster; the result is the same for any number.
  int threads = 1;
  /// Called after every iteration with its number (from 1); return false to stop with the best
  /// poses so far.
  std::function<bool(int, const IterationRecord&)> progress{};
};

/// Wall time of the phases, summed over the iterations.
struct PhaseTimes {
  double validate_s = 0.0;   ///< checks of the graph
  double analyse_s = 0.0;    ///< pattern, ordering, symbolic factorisation; 0 if reused
  double linearise_s = 0.0;  ///< errors, Jacobians, normal equations
  double factorise_s = 0.0;  ///< numeric factorisation
  double solve_s = 0.0;      ///< substitution
  double total_s = 0.0;      ///< all of the call
};

/// What the edges leave open: moving `variable` along `direction`, a right perturbation of it, with
/// the others following as it costs least, changes the cost by no more than rounding
/// (FactorOutcome has the rule).
template <int N>
struct Undetermined {
  int variable = -1;  ///< −1: none that could be named
  /// Of length one, in the first rows of a smaller variable; zero: the solver cannot tell.
  Eigen::Matrix<double, N, 1> direction = Eigen::Matrix<double, N, 1>::Zero();
};

/// "pose 8 is not fully determined by the edges, along (0.5, -0.866, 0)", and what is not known
/// left out. `name` is what messages call the variable.
[[nodiscard]] Error undetermined_error(const std::string& name, const double* direction, int size);

/// "…" for a variable of `graph`; without a variable, that not all are determined.
template <class Graph>
[[nodiscard]] Error undetermined_error(const Graph& graph,
                                       const Undetermined<Graph::kBlock>& open) {
  if (open.variable < 0) return {ErrorCode::degenerate, "the edges do not determine all variables"};
  return undetermined_error(graph.name(open.variable), open.direction.data(),
                            graph.dof(open.variable));
}

/// What an optimisation did.
struct OptimiseReport {
  double initial_chi2 = 0.0;                  ///< Σ eᵀΩe, no kernel
  double final_chi2 = 0.0;                    ///< Σ eᵀΩe at the end, no kernel
  double initial_cost = 0.0;                  ///< Σ ρ(eᵀΩe)
  double final_cost = 0.0;                    ///< Σ ρ(eᵀΩe) at the end
  int iterations = 0;                         ///< linear systems solved
  StopReason reason = StopReason::converged;  ///< why it ended
  bool fell_back = false;                     ///< from Gauss-Newton to Levenberg-Marquardt
  bool structure_reused = false;              ///< pattern and symbolic factorisation were reused
  std::vector<IterationRecord> history;       ///< of every iteration
  PhaseTimes times;                           ///< wall time
};

}  // namespace wayfare
