#pragma once

// What the matchers that climb from a prior share: the prior as a term of the least squares, the
// damped step, and the match they end with.

#include <functional>
#include <optional>
#include <string_view>

#include <wayfare/match/scan_matcher.hpp>

namespace wayfare::detail {

/// Half the squared, weighted residuals at a pose, with gradient and Gauss-Newton Hessian over its
/// right perturbation (x, y, θ).
struct Cost {
  double value = 0.0;
  Eigen::Vector3d negative_gradient = Eigen::Vector3d::Zero();  ///< minus the gradient
  Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();
};

/// Refuses what no climb can begin with.
Result<void> check_climb(std::string_view who, const PointSet& points, const SE2d& prior,
                         const SearchWindow& window, const MatchOptions& options);

/// Where a climb ended.
struct Ending {
  SE2d pose;
  double mean_log_likelihood = 0.0;
  double score = 0.0;
  double information = 1.0;  ///< of one residual: 1/σ²
  /// Σ g gᵀ of the residuals' gradients there; asked for only where a covariance is.
  std::function<Eigen::Matrix3d()> outer;
};

/// What MatchOptions ask for beside the points. Refers to all it is given.
class Prior {
 public:
  Prior(const SE2d& prior, const SearchWindow& window, const MatchOptions& options,
        const PointSet& points);

  /// Of one point's squared residual, so that as many count as are independent.
  [[nodiscard]] double weight() const { return weight_; }
  void add(const SE2d& pose, Cost& cost) const;
  /// The match a climb ended in; nothing outside the window or below the least score.
  [[nodiscard]] std::optional<MatchResult> match(const Ending& ending) const;

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

/// Steps downhill until one is shorter than the tolerance, or `max_iterations` were tried.
/// `cost_at(pose)` is a Cost; `pose` never ends where its cost is higher than at the start.
template <class CostAt>
Cost minimise(SE2d& pose, const CostAt& cost_at, int max_iterations, double tolerance);

/// (H + λ diag H)⁻¹ · downhill.
[[nodiscard]] Eigen::Vector3d damped_step(const Cost& cost, double damping);

/// √(Σ|p|²/N).
[[nodiscard]] double rms_distance_m(const PointSet& points);

/// What a point of the map, with the normal of its surface there, weighs; 0 where it is matched
/// with nothing.
using PointWeight =
    std::function<double(const Eigen::Vector2d& p_map, const Eigen::Vector2d& normal_map)>;

/// Σ w g gᵀ, g = (n, p × n), over the points that lie on lines with others of the scan, n their
/// normals. (A grid's own gradients will not do: they vanish on the walls and leave what cells and
/// noise make along them.)
[[nodiscard]] Eigen::Matrix3d normals_outer(const PointSet& points, const SE2d& T_map_points,
                                            const PointWeight& weight);

template <class CostAt>
Cost minimise(SE2d& pose, const CostAt& cost_at, int max_iterations, double tolerance) {
  constexpr double kLeastDamping = 1e-6, kMostDamping = 1e4;
  Cost here = cost_at(pose);
  double damping = 1e-4;
  for (int i = 0; i < max_iterations && damping < kMostDamping; ++i) {
    const Eigen::Vector3d step = damped_step(here, damping);
    if (!step.allFinite()) break;
    const SE2d next = pose.plus(step);
    const Cost there = cost_at(next);
    if (there.value < here.value) {
      pose = next;
      here = there;
      damping = std::max(kLeastDamping, damping * 0.1);
      if (step.norm() < tolerance) break;
    } else {
      if (step.norm() < tolerance) break;
      damping *= 10;
    }
  }
  return here;
}

}  // namespace wayfare::detail
