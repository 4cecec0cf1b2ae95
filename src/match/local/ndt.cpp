#include <wayfare/match/registration.hpp>

#include <algorithm>
#include <cmath>

#include "match/local/registration.hpp"

namespace wayfare {
namespace {

using detail::Cost;
using Level = NdtMap::Level;

/// visit(cell, offset from its mean, exp(−½ q)) for the distributions at a point.
template <class Visit>
void for_each_distribution(const Level& level, const Eigen::Vector2d& point, const Visit& visit) {
  for (int t = 0; t < Level::kTilings; ++t) {
    const NdtCell* cell = level.at(point, t);
    if (cell == nullptr) continue;
    const Eigen::Vector2d d = point - cell->mean;
    visit(*cell, d, std::exp(-0.5 * d.dot(cell->information * d)));
  }
}

/// Σ (1 − likelihood), the mean over the tilings. A right perturbation moves along the pose's axes.
Cost cost_of(const Level& level, const PointSet& points, const SE2d& pose, double weight) {
  const NdtMap::Sums sums = level.sums(points, pose);
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  axes.topLeftCorner<2, 2>() = pose.rotation().matrix();
  const double each = weight / Level::kTilings;
  Cost cost;
  cost.value = weight * static_cast<double>(points.size()) - each * sums.likelihood;
  cost.negative_gradient = -each * (axes.transpose() * sums.pull);
  cost.hessian = each * (axes.transpose() * sums.hessian * axes);
  return cost;
}

/// The most likely distribution of a point, with the likelihood relative to that at its mean.
struct Likeliest {
  const NdtCell* cell = nullptr;
  double likelihood = 0.0;
};

Likeliest likeliest(const Level& level, const Eigen::Vector2d& point) {
  Likeliest best;
  for_each_distribution(level, point, [&](const NdtCell& cell, const Eigen::Vector2d&, double e) {
    if (e > best.likelihood) best = {&cell, e};
  });
  return best;
}

struct NdtFit {
  double score = 0.0, mean_log_likelihood = 0.0;
};

NdtFit fit_at(const Level& level, const PointSet& points, const SE2d& pose,
              double floor_probability) {
  NdtFit fit;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double e = likeliest(level, pose * Eigen::Vector2d(points[i].cast<double>())).likelihood;
    fit.score += e;
    fit.mean_log_likelihood += std::log(std::max(floor_probability, e));
  }
  fit.score /= static_cast<double>(points.size());
  fit.mean_log_likelihood /= static_cast<double>(points.size());
  return fit;
}

/// Information across the surfaces only: along them the distributions reflect the squares' borders.
Eigen::Matrix3d information_at(const Level& level, const PointSet& points, const SE2d& pose) {
  return detail::normals_outer(
      points, pose, [&](const Eigen::Vector2d& p, const Eigen::Vector2d& n) {
        const Likeliest best = likeliest(level, p);
        return best.cell == nullptr ? 0.0 : best.likelihood * n.dot(best.cell->information * n);
      });
}

}  // namespace

Result<std::optional<MatchResult>> NdtMatcher::match(const NdtMap& map, const PointSet& points,
                                                     const SE2d& prior, const SearchWindow& window,
                                                     const MatchOptions& options) const {
  if (!(options_.floor_probability > 0 && options_.floor_probability < 1))
    return Error{ErrorCode::invalid, "NDT: the floor probability must lie within (0, 1)"};
  if (map.empty()) return Error{ErrorCode::invalid, "NDT: the map is empty"};
  if (auto ok = detail::check_input("NDT", points, prior, window, options); !ok) return ok.error();
  const detail::Prior prior_term(prior, window, options, points);
  SE2d pose = prior;
  for (const Level& level : map.levels()) {
    const auto cost_at = [&](const SE2d& at) {
      return cost_of(level, points, at, prior_term.weight());
    };
    prior_term.minimise(pose, cost_at, options_.max_iterations, options_.tolerance);
  }
  const Level& finest = map.levels().back();
  const NdtFit fit = fit_at(finest, points, pose, options_.floor_probability);
  return prior_term.match({pose, fit.mean_log_likelihood, fit.score, 1.0,
                           [&] { return information_at(finest, points, pose); }});
}

}  // namespace wayfare
