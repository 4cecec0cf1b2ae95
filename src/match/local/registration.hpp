#pragma once

// Shared by the iterative matchers: the prior as a term of the least squares, the damped
// minimisation, and the construction of the match.

#include <functional>
#include <optional>
#include <string_view>

#include <Eigen/Cholesky>

#include <wayfare/core/levenberg_marquardt.hpp>
#include <wayfare/match/scan_matcher.hpp>

namespace wayfare::detail {

/// Half the squared, weighted residuals at a pose, with gradient and Gauss-Newton Hessian over its
/// right perturbation (x, y, θ).
struct Cost {
  double value = 0.0;
  Eigen::Vector3d negative_gradient = Eigen::Vector3d::Zero();
  Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();
};

/// The DampedProblem of a pose: steps by (H + λ diag H + floor)⁻¹ · negative gradient, where the
/// floor of the diagonal is 1e-9·(1 + trace H) unless given.
template <class CostAt>
class PoseDescent {
 public:
  PoseDescent(const SE2d& pose, const CostAt& cost_at, double tolerance, double floor = 0.0)
      : cost_at_(cost_at),
        tolerance_(tolerance),
        floor_(floor),
        pose_(pose),
        here_(cost_at(pose)) {}

  [[nodiscard]] const SE2d& pose() const { return pose_; }
  [[nodiscard]] const SE2d& next() const { return next_; }
  [[nodiscard]] const Cost& here() const { return here_; }

  bool solve(double damping) {
    Eigen::Matrix3d damped = here_.hessian;
    damped.diagonal() *= 1 + damping;
    damped.diagonal().array() += floor_ > 0 ? floor_ : 1e-9 * (1 + here_.hessian.trace());
    step_ = damped.ldlt().solve(here_.negative_gradient);
    next_ = pose_.plus(step_);
    return step_.allFinite();
  }
  [[nodiscard]] double cost() const { return here_.value; }
  double stepped_cost() {
    there_ = cost_at_(next_);
    return there_.value;
  }
  bool accept() {
    pose_ = next_;
    here_ = there_;
    return step_.norm() < tolerance_;
  }
  [[nodiscard]] bool reject() const { return !step_.allFinite() || step_.norm() < tolerance_; }

 private:
  const CostAt& cost_at_;
  double tolerance_, floor_;
  SE2d pose_, next_;
  Cost here_, there_;
  Eigen::Vector3d step_ = Eigen::Vector3d::Zero();
};

/// Errors of the input, such as points that are not finite.
Result<void> check_input(std::string_view who, const PointSet& points, const SE2d& prior,
                         const SearchWindow& window, const MatchOptions& options);

/// The end of an iteration.
struct Solution {
  SE2d pose;
  double mean_log_likelihood = 0.0;
  double score = 0.0;
  double information = 1.0;  ///< of one residual: 1/σ²
  /// Σ g gᵀ of the residuals' gradients; called only if a covariance is requested.
  std::function<Eigen::Matrix3d()> outer;
};

/// The prior and the options of a match. Keeps references to its arguments.
class Prior {
 public:
  Prior(const SE2d& prior, const SearchWindow& window, const MatchOptions& options,
        const PointSet& points);

  /// Weight of a point's squared residual, from the number of independent points.
  [[nodiscard]] double weight() const { return weight_; }
  /// Levenberg-Marquardt steps on the sum of `cost_at(pose)` and the prior's term until one is
  /// shorter than the tolerance, `max_iterations` at most. Returns the cost, which never increases.
  template <class CostAt>
  double minimise(SE2d& pose, const CostAt& cost_at, int max_iterations, double tolerance) const {
    const auto with_prior = [&](const SE2d& at) {
      Cost cost = cost_at(at);
      add(at, cost);
      return cost;
    };
    PoseDescent descent(pose, with_prior, tolerance);
    damped_least_squares(descent, TenfoldDamping(1e-4, 1e-6, 5e3), max_iterations);
    pose = descent.pose();
    return descent.cost();
  }
  /// The match, or nothing outside the window or below the minimum score.
  [[nodiscard]] std::optional<MatchResult> match(const Solution& solution) const;

  /// Its cost at a pose.
  void add(const SE2d& pose, Cost& cost) const;

 private:
  [[nodiscard]] bool in_window(const SE2d& pose) const;
  /// The inverse of `information`, no wider than the window.
  [[nodiscard]] Eigen::Matrix3d covariance(const Eigen::Matrix3d& information) const;

  const SE2d& prior_;
  const SearchWindow& window_;
  const MatchOptions& options_;
  const PointSet& points_;
  double weight_;
};

/// √(Σ|p|²/N).
[[nodiscard]] double rms_distance_m(const PointSet& points);

/// Weight of a point, given with its surface normal; 0 for a point without a match.
using PointWeight =
    std::function<double(const Eigen::Vector2d& p_map, const Eigen::Vector2d& normal_map)>;

/// Σ w g gᵀ, g = (n, p × n), over the points with a normal n in the scan. (A grid's gradients are
/// unsuitable: they vanish on the walls, and noise along the walls remains.)
[[nodiscard]] Eigen::Matrix3d normals_outer(const PointSet& points, const SE2d& T_map_points,
                                            const PointWeight& weight);

}  // namespace wayfare::detail
