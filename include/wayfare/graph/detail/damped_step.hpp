#pragma once

// One step of an optimisation: (H + λ diag H) Δ = −g on a graph, with λ = 0 for Gauss-Newton.

#include <chrono>
#include <cstddef>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/graph/detail/normal_equations.hpp>
#include <wayfare/graph/linear_solver.hpp>
#include <wayfare/graph/report.hpp>

namespace wayfare {

/// Adds its lifetime to `seconds`.
class PhaseTimer {
 public:
  explicit PhaseTimer(double& seconds) : seconds_(seconds) {}
  PhaseTimer(const PhaseTimer&) = delete;
  PhaseTimer& operator=(const PhaseTimer&) = delete;
  ~PhaseTimer() { seconds_ += std::chrono::duration<double>(Clock::now() - start_).count(); }

 private:
  using Clock = std::chrono::steady_clock;

  double& seconds_;
  Clock::time_point start_ = Clock::now();
};

/// The equations of a kind of graph.
template <class Graph>
struct EquationsOf;
template <LieGroup G>
struct EquationsOf<PoseGraph<G>> {
  using Type = NormalEquations<G>;
};

/// Linearises a graph, solves for the step, and applies or undoes it. Reuses pattern, symbolic
/// factorisation and memory while the graph's structure is unchanged.
template <class Graph, LinearSolver Solver>
class DampedStep {
 public:
  static constexpr int kBlock = Graph::kBlock;
  using Equations = typename EquationsOf<Graph>::Type;

  /// For the factorisation, if the solver supports it.
  void set_threads(int threads) {
    if constexpr (ThreadedSolver<Solver>) solver_.set_threads(threads);
  }

  /// As before the first factorisation: nothing is known to be undetermined.
  void forget_outcome() {
    outcome_ = {};
    undamped_ = false;
  }

  /// Sets up the equations of a validated graph; returns whether the structure was reused.
  bool prepare(const Graph& graph);

  /// H and g at the graph's poses; returns Σ ρ(eᵀΩe).
  double linearise(const Graph& graph, const RobustKernel& kernel) {
    const PhaseTimer timer(times_.linearise_s);
    return equations_.linearise(graph, kernel);
  }

  /// Σ ρ(eᵀΩe), as `linearise` returns.
  double cost(const Graph& graph, const RobustKernel& kernel) {
    const PhaseTimer timer(times_.linearise_s);
    return equations_.cost(graph, kernel);
  }
  void set_weights(std::vector<double> weights) { equations_.set_weights(std::move(weights)); }
  /// Those that a factor graph's edges have.
  void ignore_kernels() {
    if constexpr (requires { equations_.use_kernels(false); }) equations_.use_kernels(false);
  }

  /// Factorises and solves; false if the poses are not determined or the solution is not finite.
  bool compute(double damping);
  /// The factorisation only.
  bool factorise(double damping = 0.0);

  /// Moves the free poses along the step.
  void apply(Graph& graph);
  void undo(Graph& graph) const { graph.set_values(saved_); }
  /// The values before `apply`.
  [[nodiscard]] const typename Graph::Values& before() const { return saved_; }

  /// Whether the last factorisation and step succeeded.
  [[nodiscard]] bool solved() const { return outcome_.ok; }
  /// Decrease of the quadratic model along the step.
  [[nodiscard]] double model_gain() const { return model_gain_; }
  [[nodiscard]] double largest() const { return step_.cwiseAbs().maxCoeff(); }
  /// Whether the last factorisation shows that the poses it was made at are determined, with digits
  /// to spare, and without damping.
  [[nodiscard]] bool determined() const { return outcome_.ok && !outcome_.weak && undamped_; }
  /// What the last factorisation, which failed, leaves open.
  [[nodiscard]] Undetermined<Graph::kBlock> undetermined() const;
  /// Why the last factorisation or solution failed.
  [[nodiscard]] Error undetermined(const Graph& graph) const {
    const Undetermined<Graph::kBlock> open = undetermined();
    if (!is_solution_ && open.variable < 0)
      return {ErrorCode::numerical, "the linear solver's solution is not finite"};
    return undetermined_error(graph, open);
  }

  [[nodiscard]] const Equations& equations() const { return equations_; }
  [[nodiscard]] Solver& solver() { return solver_; }
  [[nodiscard]] PhaseTimes& times() { return times_; }

 private:
  void damp(double damping);
  void restore();
  [[nodiscard]] int first_overflow() const;

  Equations equations_;
  Solver solver_;
  PhaseTimes times_;
  FactorOutcome outcome_;
  bool is_analysed_ = false;  // an exception may have prevented it
  bool undamped_ = false;     // that made it
  bool is_solution_ = true;   // what the solver made of it
  double model_gain_ = 0.0;
  typename Graph::Values saved_;
  Eigen::VectorXd step_, diagonal_;
};

template <class Graph, LinearSolver S>
bool DampedStep<Graph, S>::prepare(const Graph& graph) {
  const PhaseTimer timer(times_.analyse_s);
  forget_outcome();
  const bool changed = equations_.set_structure(graph) || !is_analysed_;
  is_analysed_ = false;
  if (changed && !equations_.free().empty()) solver_.analyse(equations_.hessian());
  is_analysed_ = true;
  return !changed;
}

template <class Graph, LinearSolver S>
bool DampedStep<Graph, S>::compute(double damping) {
  if (!factorise(damping)) return false;
  const PhaseTimer timer(times_.solve_s);
  step_ = -equations_.gradient();
  solver_.solve_in_place(step_);
  outcome_.ok = is_solution_ = step_.size() == equations_.gradient().size() && step_.allFinite();
  if (!outcome_.ok) return false;
  // (H + λD)Δ = −g, so the model decreases by −2gᵀΔ − ΔᵀHΔ = −gᵀΔ + λ ΔᵀDΔ.
  model_gain_ = -equations_.gradient().dot(step_);
  if (damping > 0.0) model_gain_ += damping * step_.cwiseAbs2().dot(diagonal_);
  return true;
}

template <class Graph, LinearSolver S>
bool DampedStep<Graph, S>::factorise(double damping) {
  const PhaseTimer timer(times_.factorise_s);
  undamped_ = damping == 0.0;
  is_solution_ = true;
  if (damping > 0.0) damp(damping);
  outcome_ = solver_.factorise(equations_.hessian());
  if (damping > 0.0) restore();
  return outcome_.ok;
}

template <class Graph, LinearSolver S>
void DampedStep<Graph, S>::damp(double damping) {
  auto& h = equations_.hessian();
  diagonal_.resize(equations_.gradient().size());
  for (int c = 0; c < h.columns(); ++c) {
    auto block = h.block(h.diagonal_index(c));
    diagonal_.template segment<kBlock>(c * kBlock) = block.diagonal();
    block.diagonal() *= 1.0 + damping;
  }
}

template <class Graph, LinearSolver S>
void DampedStep<Graph, S>::restore() {
  auto& h = equations_.hessian();
  for (int c = 0; c < h.columns(); ++c) {
    h.block(h.diagonal_index(c)).diagonal() = diagonal_.template segment<kBlock>(c * kBlock);
  }
}

template <class Graph, LinearSolver S>
void DampedStep<Graph, S>::apply(Graph& graph) {
  saved_ = graph.values();
  int column = 0;
  for (const int variable : equations_.free()) {
    graph.move(variable, step_.template segment<kBlock>(kBlock * column++));
  }
}

template <class Graph, LinearSolver S>
Undetermined<Graph::kBlock> DampedStep<Graph, S>::undetermined() const {
  Undetermined<Graph::kBlock> open;
  if (outcome_.ok) return open;
  const bool named = outcome_.block >= 0 && outcome_.block < equations_.hessian().columns();
  const int block = named ? outcome_.block : first_overflow();
  if (block < 0) return open;
  open.variable = equations_.free()[static_cast<std::size_t>(block)];
  open.direction = Eigen::Map<const Eigen::Matrix<double, kBlock, 1>>(outcome_.direction.data());
  return open;
}

/// The first block column with an overflow; −1 if there is none.
template <class Graph, LinearSolver S>
int DampedStep<Graph, S>::first_overflow() const {
  const auto& h = equations_.hessian();
  for (int c = 0; c < h.columns(); ++c)
    if (!h.block(h.diagonal_index(c)).allFinite()) return c;
  return -1;
}

namespace detail {

/// Columns of H⁻¹, with one solve each; not a number if the solution has another size.
template <int N, LinearSolver Solver>
void solve_joint(Solver& solver, const int (&columns)[2], Eigen::Index size,
                 Eigen::Matrix<double, 2 * N, 2 * N>& joint) {
  Eigen::VectorXd x(size);
  for (int side = 0; side < 2; ++side) {
    if (columns[side] < 0) continue;
    for (int k = 0; k < N; ++k) {
      x.setZero();
      x[columns[side] * N + k] = 1.0;
      solver.solve_in_place(x);
      if (x.size() != size) x.setConstant(size, std::numeric_limits<double>::quiet_NaN());
      for (int row = 0; row < 2; ++row) {
        if (columns[row] < 0) continue;
        joint.template block<N, 1>(row * N, side * N + k) = x.template segment<N>(columns[row] * N);
      }
    }
  }
}

/// From the solver's selected inverse; false if a block is missing there.
template <int N, LinearSolver Solver>
bool look_up_joint(const Solver& solver, const int (&columns)[2],
                   Eigen::Matrix<double, 2 * N, 2 * N>& joint) {
  if constexpr (SelectedInverse<Solver>) {
    Eigen::Matrix<double, N, N> block;
    for (int row = 0; row < 2; ++row) {
      for (int side = 0; side < 2; ++side) {
        if (columns[row] < 0 || columns[side] < 0) continue;
        if (!solver.inverse_block(columns[row], columns[side], block)) return false;
        joint.template block<N, N>(row * N, side * N) = block;
      }
    }
    return true;
  }
  return false;
}

}  // namespace detail

/// The joint covariance of two variables (a first), as right perturbations of them: their rows and
/// columns of H⁻¹, zero for a fixed one. `solver` has factorised `equations`' H; blocks of its
/// selected inverse are looked up.
template <class Equations, LinearSolver Solver>
[[nodiscard]] auto joint_covariance(const Equations& equations, Solver& solver, int a, int b) {
  constexpr int kDof = Equations::Matrix::kBlock;
  Eigen::Matrix<double, 2 * kDof, 2 * kDof> joint;
  joint.setZero();
  const int columns[2] = {equations.column(a), equations.column(b)};
  if (detail::look_up_joint<kDof>(solver, columns, joint)) return joint;
  detail::solve_joint<kDof>(solver, columns, equations.gradient().size(), joint);
  return joint;
}

}  // namespace wayfare
