#include <wayfare/match/gauss_newton.hpp>

#include <cmath>

#include <Eigen/Cholesky>

#include <wayfare/core/levenberg_marquardt.hpp>

#include "map/kernels/kernels.hpp"
#include "map/table_view.hpp"
#include "match/local/registration.hpp"

namespace wayfare {
namespace {

struct Sum {
  double log_likelihood = 0.0;
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
};

/// r = √(−2 ln p + ε): J = −∇ln p / r. ε bounds the weight of a point on its surface.
Sum linearise(const LikelihoodField& grid, const PointSet& points, const SE2d& pose) {
  constexpr double kEpsilon = 0.05;
  const double inverse = 1 / grid.resolution_m(), step = grid.log_step();
  double sums[10];
  kernels::best_kernels().linearise(
      points.padded_x_m().data(), points.padded_y_m().data(), static_cast<int>(points.size()),
      detail::transform_into(grid, pose), detail::field_of(grid),
      static_cast<float>(-2 * grid.log_floor() + kEpsilon), static_cast<float>(-2 * step), sums);
  Sum sum;
  const double per_metre = step * inverse;
  sum.log_likelihood = grid.log_floor() * static_cast<double>(points.size()) + step * sums[0];
  sum.gradient = per_metre * Eigen::Vector3d(sums[1], sums[2], sums[3]);
  sum.information << sums[4], sums[5], sums[6], sums[5], sums[7], sums[8], sums[6], sums[8],
      sums[9];
  sum.information *= per_metre * per_metre;
  return sum;
}

/// The DampedProblem whose cost is −Σ ln p; no step leads out of the allowed shift.
class FieldAlignment {
 public:
  FieldAlignment(const LikelihoodField& grid, const PointSet& points, const SE2d& start,
                 const RefineOptions& options)
      : grid_(grid),
        points_(points),
        start_(start),
        options_(options),
        pose_(start),
        here_(linearise(grid, points, start)) {}

  [[nodiscard]] const SE2d& pose() const { return pose_; }
  [[nodiscard]] const Sum& here() const { return here_; }
  [[nodiscard]] bool moved() const { return moved_; }

  bool solve(double damping) {
    Eigen::Matrix3d damped = here_.information;
    damped.diagonal() *= 1 + damping;
    damped.diagonal().array() += 1e-6;
    step_ = damped.ldlt().solve(here_.gradient);
    next_ = pose_.plus(step_);
    return step_.allFinite() &&
           (next_.translation() - start_.translation()).norm() < options_.max_shift_m;
  }
  [[nodiscard]] double cost() const { return -here_.log_likelihood; }
  double stepped_cost() {
    there_ = linearise(grid_, points_, next_);
    return -there_.log_likelihood;
  }
  bool accept() {
    pose_ = next_;
    here_ = there_;
    moved_ = true;
    return step_.norm() < options_.tolerance;
  }
  static bool reject() { return false; }

 private:
  const LikelihoodField& grid_;
  const PointSet& points_;
  const SE2d& start_;
  const RefineOptions& options_;
  SE2d pose_, next_;
  Sum here_, there_;
  Eigen::Vector3d step_ = Eigen::Vector3d::Zero();
  bool moved_ = false;
};

}  // namespace

FieldSample interpolate(const LikelihoodField& grid, const Eigen::Vector2d& p_map) {
  const double inverse = 1 / grid.resolution_m();
  const double u = p_map.x() * inverse - grid.origin().x - 0.5;
  const double v = p_map.y() * inverse - grid.origin().y - 0.5;
  if (!(u > -1 && v > -1 && u < grid.width() && v < grid.height()))
    return {grid.log_floor(), Eigen::Vector2d::Zero()};
  const int column = static_cast<int>(u + 1) - 1, row = static_cast<int>(v + 1) - 1;
  const double a = u - column, b = v - row;
  const std::uint16_t* p = grid.data() + std::ptrdiff_t{row} * grid.stride() + column;
  const double p00 = p[0], p10 = p[1], p01 = p[grid.stride()], p11 = p[grid.stride() + 1];
  const double low = p00 + a * (p10 - p00), high = p01 + a * (p11 - p01);
  const double step = grid.log_step();
  const double dx = (1 - b) * (p10 - p00) + b * (p11 - p01);
  return {grid.log_floor() + step * (low + b * (high - low)),
          Eigen::Vector2d(dx, high - low) * (step * inverse)};
}

Result<RefineResult> refine(const LikelihoodField& grid, const PointSet& points, const SE2d& start,
                            const RefineOptions& options) {
  if (grid.empty()) return Error{ErrorCode::invalid, "refine: the map is empty"};
  if (points.empty()) return Error{ErrorCode::invalid, "refine: no points"};
  if (!start.translation().allFinite() || !std::isfinite(start.heading().radians()))
    return Error{ErrorCode::invalid, "refine: the start is not finite"};
  if (!detail::all_finite(points))
    return Error{ErrorCode::invalid, "refine: a point is not finite"};
  FieldAlignment alignment(grid, points, start, options);
  RefineResult r;
  r.iterations =
      damped_least_squares(alignment, TenfoldDamping(1e-3, 1e-6, 1e4), options.max_iterations)
          .iterations;
  r.T_map_points = alignment.pose();
  r.moved = alignment.moved();
  const Sum& here = alignment.here();
  const double n = static_cast<double>(points.size());
  r.mean_log_likelihood = here.log_likelihood / n;
  r.score = 1 - r.mean_log_likelihood / grid.log_floor();
  r.information = here.information;
  return r;
}

}  // namespace wayfare
