#include <wayfare/match/gauss_newton.hpp>

#include <algorithm>
#include <cmath>
#include <vector>

#include "map/kernels/kernels.hpp"
#include "match/local/registration.hpp"

namespace wayfare {
namespace {

using detail::Cost;

/// What an interpolating kernel sums over the points: a value, its gradient, and the upper triangle
/// of weighted outer products of gradients, per cell and in units of the table.
struct Sums {
  double value;
  Eigen::Vector3d gradient;
  Eigen::Matrix3d outer;
};

template <class Kernel, class... Parameters>
Sums sums_at(Kernel kernel, const PaddedTable& table, const PointSet& points,
             const SE2d& T_map_points, Parameters... parameters) {
  // From the points' frame to columns and rows, cell centres at integers.
  const double cells = 1 / table.resolution_m();
  const kernels::CellTransform to_cells{
      static_cast<float>(T_map_points.rotation().cos() * cells),
      static_cast<float>(T_map_points.rotation().sin() * cells),
      static_cast<float>(T_map_points.x() * cells - table.origin().x - 0.5),
      static_cast<float>(T_map_points.y() * cells - table.origin().y - 0.5),
      0,
      0,
      0};
  double sums[10];
  kernel(points.padded_x_m().data(), points.padded_y_m().data(), static_cast<int>(points.size()),
         to_cells, {table.data(), table.stride(), table.width(), table.height()},
         static_cast<float>(parameters)..., sums);
  Sums s{sums[0], {sums[1], sums[2], sums[3]}, {}};
  s.outer << sums[4], sums[5], sums[6], sums[5], sums[7], sums[8], sums[6], sums[8], sums[9];
  return s;
}

/// ½ Σr², with r = √(−2 ln p + ε) and J = −∇ln p / r. ε bounds the weight of a point on its
/// surface.
Cost negative_log_likelihood(const LikelihoodField& grid, const PointSet& points,
                             const SE2d& pose) {
  constexpr double kEpsilon = 0.05;
  const double inverse = 1 / grid.resolution_m(), step = grid.log_step();
  const Sums s = sums_at(kernels::best_kernels().linearise, grid, points, pose,
                         -2 * grid.log_floor() + kEpsilon, -2 * step);
  const double per_metre = step * inverse;
  return {-(grid.log_floor() * static_cast<double>(points.size()) + step * s.value),
          per_metre * s.gradient, s.outer * (per_metre * per_metre)};
}

/// No step leads out of the allowed shift.
template <class CostAt>
class Refinement : public detail::PoseDescent<CostAt> {
 public:
  Refinement(const SE2d& start, const CostAt& cost_at, const RefineOptions& options)
      : detail::PoseDescent<CostAt>(start, cost_at, options.tolerance, 1e-6),
        start_(start),
        max_shift_m_(options.max_shift_m) {}

  bool solve(double damping) {
    return detail::PoseDescent<CostAt>::solve(damping) &&
           (this->next().translation() - start_.translation()).norm() < max_shift_m_;
  }
  static bool reject() { return false; }

 private:
  const SE2d& start_;
  double max_shift_m_;
};

/// Σr², −Σr·∂r/∂ξ and the outer products of ∂r/∂ξ over the points, r = 1 − p.
Cost squares_at(const ProbabilityGrid& grid, Interpolation interpolation, const PointSet& points,
                const SE2d& pose) {
  constexpr double kOne = ProbabilityGrid::kOne;
  const double inverse = 1 / grid.resolution_m();
  const kernels::Kernels& k = kernels::best_kernels();
  const Sums s =
      sums_at(interpolation == Interpolation::bilinear ? k.bilinear_squares : k.bicubic_squares,
              grid, points, pose, kOne);
  const double per_metre = inverse / kOne;
  return {s.value / (kOne * kOne), per_metre / kOne * s.gradient,
          s.outer * (per_metre * per_metre)};
}

Result<void> check_map(const ProbabilityPyramid& map) {
  if (map.empty()) return Error{ErrorCode::invalid, "Gauss-Newton matching: the map is empty"};
  for (const ProbabilityGrid& table : map)
    if (table.empty()) return Error{ErrorCode::invalid, "Gauss-Newton matching: a table is empty"};
  return {};
}

/// The prior rotated within the window in both directions, nearest first.
std::vector<SE2d> rotated_starts(const SE2d& prior, const SearchWindow& window, Angle step) {
  constexpr double kMost = 36;
  std::vector<SE2d> starts;
  if (!(step.radians() > 0)) return starts;
  const int n = static_cast<int>(std::min(kMost, window.half_heading.radians() / step.radians()));
  for (int k = 1; k <= n; ++k)
    for (const double side : {-1.0, 1.0})
      starts.emplace_back(prior.translation(), prior.rotation() * SO2d(step * (side * k)));
  return starts;
}

/// Increase of Σr² from `pose` to `moved`, over the points in observed cells at both.
double cost_increase(const ProbabilityGrid& grid, const PointSet& points, const SE2d& pose,
                     const SE2d& moved) {
  constexpr double kOne = ProbabilityGrid::kOne;
  double sum = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector2d p = points[i].cast<double>();
    const int here = grid.value(cell_of(pose * p, grid.resolution_m()));
    const int there = grid.value(cell_of(moved * p, grid.resolution_m()));
    if (here == grid.unknown() || there == grid.unknown()) continue;
    sum += (here - there) * (2 * kOne - here - there);
  }
  return sum / (kOne * kOne);
}

/// SceneConstraint::displacement_cost_nats, scaled to kIndependent points.
double displacement_cost_nats(const ProbabilityGrid& grid, const PointSet& points, const SE2d& pose,
                              const Eigen::Vector3d& weakest, double variance) {
  constexpr double kStep_m = 0.25, kIndependent = 20.0;
  const double rms_m = detail::rms_distance_m(points);
  if (!(rms_m > 0)) return 0.0;
  const Eigen::Vector3d step = kStep_m * weakest.cwiseQuotient(Eigen::Vector3d(1, 1, rms_m));
  return 0.5 * kIndependent / (static_cast<double>(points.size()) * variance) *
         std::min(cost_increase(grid, points, pose, pose.plus(step)),
                  cost_increase(grid, points, pose, pose.plus(Eigen::Vector3d(-step))));
}

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
  if (auto ok = detail::check_input("refine", points, start, {}, {}); !ok) return ok.error();
  const auto result = [&](const SE2d& pose, const Cost& points_only, int iterations) {
    const double mean = -points_only.value / static_cast<double>(points.size());
    return RefineResult{pose, mean, 1 - mean / grid.log_floor(), points_only.hessian, iterations};
  };
  const auto descend = [&](const auto& cost_at, const auto& points_only_at) {
    Refinement refinement(start, cost_at, options);
    const int iterations =
        damped_least_squares(refinement, TenfoldDamping(1e-3, 1e-6, 1e4), options.max_iterations)
            .iterations;
    return result(refinement.pose(), points_only_at(refinement), iterations);
  };
  const auto cost_at = [&](const SE2d& pose) {
    return negative_log_likelihood(grid, points, pose);
  };
  if (!options.prior) return descend(cost_at, [](const auto& r) { return r.here(); });

  MatchOptions of_prior;
  of_prior.prior_information = options.prior->information;
  of_prior.independent_points = options.prior->independent_points;
  const SearchWindow anywhere;
  if (auto ok = detail::check_input("refine", points, options.prior->pose, anywhere, of_prior); !ok)
    return ok.error();
  const detail::Prior prior(options.prior->pose, anywhere, of_prior, points);
  const auto with_prior = [&](const SE2d& pose) {
    const Cost s = cost_at(pose);
    Cost cost{prior.weight() * s.value, prior.weight() * s.negative_gradient,
              prior.weight() * s.hessian};
    prior.add(pose, cost);
    return cost;
  };
  return descend(with_prior, [&](const auto& r) { return cost_at(r.pose()); });
}

Result<std::optional<MatchResult>> GaussNewtonMatcher::match(const ProbabilityPyramid& map,
                                                             const PointSet& points,
                                                             const SE2d& prior,
                                                             const SearchWindow& window,
                                                             const MatchOptions& options) const {
  if (!(options_.residual_sigma > 0) || !(options_.point_sigma_m > 0))
    return Error{ErrorCode::invalid, "Gauss-Newton matching: a sigma is not positive"};
  if (auto ok = check_map(map); !ok) return ok.error();
  if (auto ok = detail::check_input("Gauss-Newton matching", points, prior, window, options); !ok)
    return ok.error();
  const detail::Prior prior_term(prior, window, options, points);
  const double variance = options_.residual_sigma * options_.residual_sigma;
  const double weight = prior_term.weight() / variance;
  const auto minimise_on = [&](const ProbabilityGrid& table, SE2d& pose) {
    const auto cost_at = [&](const SE2d& at) {
      const Cost s = squares_at(table, options_.interpolation, points, at);
      return Cost{0.5 * weight * s.value, weight * s.negative_gradient, weight * s.hessian};
    };
    return prior_term.minimise(pose, cost_at, options_.max_iterations, options_.tolerance);
  };
  SE2d pose = prior;
  double least = minimise_on(map.front(), pose);
  for (const SE2d& start : rotated_starts(prior, window, options_.start_step)) {
    SE2d other = start;
    const double cost = minimise_on(map.front(), other);
    if (cost >= least) continue;
    least = cost;
    pose = other;
  }
  for (std::size_t level = 1; level < map.size(); ++level) minimise_on(map[level], pose);
  const double end = squares_at(map.back(), options_.interpolation, points, pose).value;
  const double n = static_cast<double>(points.size());
  const auto on_a_wall = [&finest = map.back()](const Eigen::Vector2d& p, const Eigen::Vector2d&) {
    return 2 * finest.value(cell_of(p, finest.resolution_m())) > ProbabilityGrid::kOne ? 1.0 : 0.0;
  };
  auto result = prior_term.match({pose, -end / (2 * n * variance), 1 - std::sqrt(end / n),
                                  1 / (options_.point_sigma_m * options_.point_sigma_m),
                                  [&] { return detail::normals_outer(points, pose, on_a_wall); }});
  if (result && result->constraint)
    result->constraint->displacement_cost_nats =
        displacement_cost_nats(map.back(), points, pose, result->constraint->weakest, variance);
  return result;
}

}  // namespace wayfare
