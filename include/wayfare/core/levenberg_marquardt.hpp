#pragma once

// Nonlinear least squares by Levenberg-Marquardt: steps Δ of (H + λD) Δ = −g with H = JᵀJ,
// g = Jᵀr, taken where they lower the cost; λ falls after a step that did and grows after one that
// did not.
//
// K. Levenberg, "A method for the solution of certain non-linear problems in least squares",
//   Quarterly of Applied Mathematics 2 (1944): the damping λ.
// D. Marquardt, "An algorithm for least-squares estimation of nonlinear parameters", J. SIAM 11
//   (1963): D = diag H, which makes the step independent of units; λ changed by factors of ten.
// H. B. Nielsen, "Damping parameter in Marquardt's method", IMM-REP-1999-05: λ by the gain ratio.
// K. Madsen, H. B. Nielsen, O. Tingleff, "Methods for non-linear least squares problems", 2nd
//   edition (2004), algorithm 3.16.

#include <algorithm>
#include <cmath>
#include <concepts>
#include <limits>
#include <string_view>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <wayfare/core/manifold.hpp>
#include <wayfare/core/result.hpp>

namespace wayfare {

/// Why an iterative minimisation ended.
enum class StopReason {
  converged,       ///< the gain fell below its threshold
  max_iterations,  ///< the estimate is the best so far
  stopped,         ///< by the progress callback
  no_progress,     ///< no damping up to its maximum lowers the cost
};

/// In words, for reports.
[[nodiscard]] constexpr std::string_view to_string(StopReason reason) {
  switch (reason) {
    case StopReason::converged:
      return "converged";
    case StopReason::max_iterations:
      return "iteration limit";
    case StopReason::stopped:
      return "stopped on request";
    case StopReason::no_progress:
      return "no step lowers the cost";
  }
  return "";
}

/// λ as in Nielsen 1999 (Madsen, Nielsen, Tingleff 2004, algorithm 3.16).
class NielsenDamping {
 public:
  /// Exhausted where λ would pass `max`.
  explicit NielsenDamping(double start, double max = std::numeric_limits<double>::infinity())
      : value_(start), max_(max) {}

  /// λ.
  [[nodiscard]] double value() const { return value_; }
  /// Whether λ passed its limit.
  [[nodiscard]] bool exhausted() const { return value_ > max_; }
  /// After a step that lowered the cost by `gain_ratio` times what the quadratic model predicted.
  void step_taken(double gain_ratio) {
    value_ *= std::max(1.0 / 3.0, 1.0 - std::pow(2.0 * gain_ratio - 1.0, 3));
    growth_ = 2.0;
  }
  /// After a step that did not lower the cost.
  void step_refused() {
    value_ *= growth_;
    growth_ *= 2.0;
  }

 private:
  double value_;
  double max_;
  double growth_ = 2.0;
};

/// λ as in Marquardt 1963: a tenth after each step taken, tenfold after each one refused.
class TenfoldDamping {
 public:
  /// Never below `min`; exhausted where λ would pass `max`.
  TenfoldDamping(double start, double min, double max) : value_(start), min_(min), max_(max) {}

  /// λ.
  [[nodiscard]] double value() const { return value_; }
  /// Whether λ passed its limit.
  [[nodiscard]] bool exhausted() const { return value_ > max_; }
  /// After a step that lowered the cost.
  void step_taken() { value_ = std::max(min_, value_ * 0.1); }
  /// After a step that did not.
  void step_refused() { value_ *= 10; }

 private:
  double value_;
  double min_;
  double max_;
};

/// A damping schedule that needs the gain ratio of each step taken.
template <class D>
concept GainRatioDamping = requires(D& d, double gain_ratio) {
  d.step_taken(gain_ratio);
};

/// How λ changes. `exhausted`: no larger λ needs to be tried.
template <class D>
concept DampingSchedule = requires(D& d, const D& c) {
  { c.value() } -> std::convertible_to<double>;
  { c.exhausted() } -> std::convertible_to<bool>;
  d.step_refused();
}
&&(GainRatioDamping<D> || requires(D & d) { d.step_taken(); });

/// An estimate, linearised, and the last step computed from there.
template <class P>
concept DampedProblem = requires(P& p, const P& c, double damping) {
  /// Computes the step for λ; false where there is none (singular, not finite, out of bounds).
  { p.solve(damping) } -> std::same_as<bool>;
  /// At the estimate.
  { c.cost() } -> std::convertible_to<double>;
  /// Evaluates the cost with the step applied; NaN or infinity where it has none.
  { p.stepped_cost() } -> std::convertible_to<double>;
  /// Moves the estimate by the step and linearises there; true where that is the solution.
  { p.accept() } -> std::same_as<bool>;
  /// Keeps the estimate; true where it is the solution. Also called where `solve` gave no step.
  { p.reject() } -> std::same_as<bool>;
};

/// A problem that knows by how much the quadratic model falls along the step.
template <class P>
concept ModelledProblem = DampedProblem<P> && requires(const P& p) {
  { p.model_gain() } -> std::convertible_to<double>;
};

/// How the loop ended.
struct DampedReport {
  int iterations = 0;                              ///< steps computed, refused ones too
  StopReason reason = StopReason::max_iterations;  ///< why it ended
};

/// The loop itself, for any problem and damping schedule. Takes a step if it lowers the cost, so
/// the cost never rises.
template <DampedProblem P, DampingSchedule D>
requires(!GainRatioDamping<D> || ModelledProblem<P>) DampedReport
    damped_least_squares(P& problem, D damping, int max_iterations) {
  DampedReport report;
  while (report.iterations < max_iterations) {
    ++report.iterations;
    const double cost = problem.cost();
    const double stepped = problem.solve(damping.value()) ? problem.stepped_cost()
                                                          : std::numeric_limits<double>::infinity();
    const bool lower = stepped < cost;  // not so for NaN
    if (lower) {
      if constexpr (GainRatioDamping<D>) {
        damping.step_taken((cost - stepped) / problem.model_gain());
      } else {
        damping.step_taken();
      }
    } else {
      damping.step_refused();
    }
    if (lower ? problem.accept() : problem.reject()) {
      report.reason = StopReason::converged;
      break;
    }
    if (damping.exhausted()) {
      report.reason = StopReason::no_progress;
      break;
    }
  }
  return report;
}

/// Residual and its Jacobian over the tangent of M: r(x ⊞ τ) ≈ r + J τ. `Rows` may be
/// Eigen::Dynamic.
template <Manifold M, int Rows = Eigen::Dynamic>
struct ResidualAndJacobian {
  using Scalar = typename ManifoldTraits<M>::Scalar;              ///< floating point
  Eigen::Matrix<Scalar, Rows, 1> residual;                        ///< r
  Eigen::Matrix<Scalar, Rows, ManifoldTraits<M>::kDof> jacobian;  ///< J
};

/// f(x) returns a ResidualAndJacobian, or any type with these two members.
template <class F, class M>
concept ResidualFunction = Manifold<M> && requires(const F& f, const M& x) {
  { f(x).residual.squaredNorm() } -> std::convertible_to<typename ManifoldTraits<M>::Scalar>;
  {SquareOf<M>(f(x).jacobian.transpose() * f(x).jacobian)};
  {TangentOf<M>(f(x).jacobian.transpose() * f(x).residual)};
};

/// Limits of the iteration.
struct LevenbergMarquardtOptions {
  int max_iterations = 100;  ///< steps computed at most, refused ones too
  /// Converged where no column of J makes an angle with the residual whose cosine is above this.
  /// The fall still possible is about its square times the cost: below the root of the machine
  /// precision it is lost in rounding.
  double gradient_tolerance = 1e-8;
  /// … or where a step is shorter than this (norm of the tangent vector, in its own units).
  double step_tolerance = 1e-10;
  double initial_damping = 1e-4;  ///< λ₀, relative to diag H; larger: more careful start
  double max_damping = 1e12;      ///< stops (no_progress) when λ would pass this
};

/// The solution and how it was reached.
template <Manifold M>
struct LevenbergMarquardtResult {
  M estimate;         ///< the solution
  double cost = 0.0;  ///< ½ Σ r²
  /// JᵀJ at the estimate: the inverse of its covariance if the residuals are in standard
  /// deviations; singular along directions that they do not determine.
  SquareOf<M> information;
  int iterations = 0;                              ///< steps computed, refused ones too
  StopReason reason = StopReason::max_iterations;  ///< why it ended
};

/// A DampedProblem of few unknowns, kept dense. Refers to all it is given.
template <Manifold M, ResidualFunction<M> F>
class DenseLeastSquares {
 public:
  using Scalar = typename ManifoldTraits<M>::Scalar;  ///< floating point

  /// Linearises at `start`.
  DenseLeastSquares(const M& start, const F& f, const LevenbergMarquardtOptions& options)
      : f_(f), options_(options), here_(linearise(start)) {}

  /// Whether the cost of the estimate is finite.
  [[nodiscard]] bool finite() const { return std::isfinite(here_.cost); }
  /// Whether the estimate meets the gradient tolerance.
  [[nodiscard]] bool stationary() const {
    const auto limit = Scalar(options_.gradient_tolerance * std::sqrt(2.0 * here_.cost));
    return (here_.negative_gradient.array().abs() <=
            limit * here_.hessian.diagonal().array().sqrt())
        .all();
  }
  /// The estimate as it is now.
  [[nodiscard]] LevenbergMarquardtResult<M> result(const DampedReport& report) const {
    return {here_.x, here_.cost, here_.hessian, report.iterations, report.reason};
  }

  /// Computes the step of (H + λ diag H) Δ = −g; false where it does not exist.
  bool solve(double damping) {
    // A direction that no residual depends on gets any positive damping: its step is zero.
    const TangentOf<M> diagonal = here_.hessian.diagonal();
    scaled_ = Scalar(damping) * (diagonal.array() > Scalar(0)).select(diagonal, Scalar(1));
    SquareOf<M> damped = here_.hessian;
    damped.diagonal() += scaled_;
    const Eigen::LDLT<SquareOf<M>> factors(damped);
    step_ = factors.solve(here_.negative_gradient);
    return factors.info() == Eigen::Success && factors.isPositive() && step_.allFinite();
  }
  /// ½ Σ r² of the estimate.
  [[nodiscard]] double cost() const { return here_.cost; }
  /// ½ Σ r² after the step.
  double stepped_cost() {
    there_ = linearise(ManifoldTraits<M>::plus(here_.x, step_));
    return there_.cost;
  }
  /// ½ Δᵀ(λDΔ − g) (Madsen, Nielsen, Tingleff 2004, 3.14).
  [[nodiscard]] double model_gain() const {
    return 0.5 * double(step_.dot(scaled_.cwiseProduct(step_) + here_.negative_gradient));
  }
  /// Takes the step; true where the estimate is the solution.
  bool accept() {
    here_ = there_;
    refused_ = false;
    return stationary() || is_short();
  }
  /// A step shortened by damping is no sign of convergence: only the first one from an estimate is.
  bool reject() { return !std::exchange(refused_, true) && is_short(); }

 private:
  struct Linearisation {
    M x;
    double cost;  ///< infinite where residual or Jacobian is not finite
    TangentOf<M> negative_gradient;
    SquareOf<M> hessian;
  };

  [[nodiscard]] Linearisation linearise(const M& x) const {
    const auto at = f_(x);
    Linearisation l{x, 0.5 * double(at.residual.squaredNorm()),
                    -(at.jacobian.transpose() * at.residual),
                    at.jacobian.transpose() * at.jacobian};
    if (!std::isfinite(l.cost) || !l.negative_gradient.allFinite() || !l.hessian.allFinite())
      l.cost = std::numeric_limits<double>::infinity();
    return l;
  }
  [[nodiscard]] bool is_short() const { return double(step_.norm()) <= options_.step_tolerance; }

  const F& f_;
  const LevenbergMarquardtOptions& options_;
  Linearisation here_;
  Linearisation there_ = here_;
  TangentOf<M> step_ = TangentOf<M>::Zero(), scaled_ = TangentOf<M>::Zero();
  bool refused_ = false;
};

/// The x near `start` at which ½ Σ r² is least, for a few unknowns. Each iteration calls
/// `residual_and_jacobian` once; where it returns a number that is not finite, the step is refused.
/// An Error where it does so at the start.
///
///   const auto fit = levenberg_marquardt(start, [&](const SE2d& x) {
///     return ResidualAndJacobian<SE2d, 2>{…, …};
///   });
template <Manifold M, ResidualFunction<M> F>
[[nodiscard]] Result<LevenbergMarquardtResult<M>> levenberg_marquardt(
    const M& start, const F& residual_and_jacobian, const LevenbergMarquardtOptions& options = {}) {
  DenseLeastSquares<M, F> problem(start, residual_and_jacobian, options);
  if (!problem.finite())
    return Error{ErrorCode::numerical,
                 "Levenberg-Marquardt: residual or Jacobian is not finite at the start"};
  if (problem.stationary()) return problem.result({0, StopReason::converged});
  return problem.result(
      damped_least_squares(problem, NielsenDamping(options.initial_damping, options.max_damping),
                           options.max_iterations));
}

}  // namespace wayfare
