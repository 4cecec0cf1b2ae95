#include <wayfare/match/gauss_newton.hpp>

#include <algorithm>
#include <cmath>
#include <vector>

#include "map/kernels/kernels.hpp"
#include "map/table_view.hpp"
#include "match/local/registration.hpp"

namespace wayfare {
namespace {

using detail::Cost;

/// Σr² and Σr·g over the points, r = 1 − p, g = ∂p/∂ξ.
struct Squares {
  double squares = 0.0;
  Eigen::Vector3d negative_gradient = Eigen::Vector3d::Zero();
  Eigen::Matrix3d outer = Eigen::Matrix3d::Zero();
};

Squares squares_at(const ProbabilityGrid& grid, Interpolation interpolation, const PointSet& points,
                   const SE2d& pose) {
  constexpr double kOne = ProbabilityGrid::kOne;
  const double inverse = 1 / grid.resolution_m();
  const kernels::Kernels& k = kernels::best_kernels();
  double sums[10];
  (interpolation == Interpolation::bilinear ? k.bilinear_squares : k.bicubic_squares)(
      points.padded_x_m().data(), points.padded_y_m().data(), static_cast<int>(points.size()),
      detail::transform_into(grid, pose), detail::field_of(grid), static_cast<float>(kOne), sums);
  const double per_metre = inverse / kOne;
  Squares s;
  s.squares = sums[0] / (kOne * kOne);
  s.negative_gradient = per_metre / kOne * Eigen::Vector3d(sums[1], sums[2], sums[3]);
  s.outer << sums[4], sums[5], sums[6], sums[5], sums[7], sums[8], sums[6], sums[8], sums[9];
  s.outer *= per_metre * per_metre;
  return s;
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

Result<std::optional<MatchResult>> GaussNewtonMatcher::match(const ProbabilityPyramid& map,
                                                             const PointSet& points,
                                                             const SE2d& prior,
                                                             const SearchWindow& window,
                                                             const MatchOptions& options) const {
  if (auto ok = check_map(map); !ok) return ok.error();
  if (auto ok = detail::check_input("Gauss-Newton matching", points, prior, window, options); !ok)
    return ok.error();
  const detail::Prior prior_term(prior, window, options, points);
  const double variance = options_.residual_sigma * options_.residual_sigma;
  const double weight = prior_term.weight() / variance;
  const auto minimise_on = [&](const ProbabilityGrid& table, SE2d& pose) {
    const auto cost_at = [&](const SE2d& at) {
      const Squares s = squares_at(table, options_.interpolation, points, at);
      Cost cost{0.5 * weight * s.squares, weight * s.negative_gradient, weight * s.outer};
      prior_term.add(at, cost);
      return cost;
    };
    return detail::minimise(pose, cost_at, options_.max_iterations, options_.tolerance).value;
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
  const Squares end = squares_at(map.back(), options_.interpolation, points, pose);
  const double n = static_cast<double>(points.size());
  const auto on_a_wall = [&finest = map.back()](const Eigen::Vector2d& p, const Eigen::Vector2d&) {
    return 2 * finest.value(cell_of(p, finest.resolution_m())) > ProbabilityGrid::kOne ? 1.0 : 0.0;
  };
  auto result =
      prior_term.match({pose, -end.squares / (2 * n * variance), 1 - std::sqrt(end.squares / n),
                        1 / (options_.point_sigma_m * options_.point_sigma_m),
                        [&] { return detail::normals_outer(points, pose, on_a_wall); }});
  if (result && result->constraint)
    result->constraint->displacement_cost_nats =
        displacement_cost_nats(map.back(), points, pose, result->constraint->weakest, variance);
  return result;
}

}  // namespace wayfare
