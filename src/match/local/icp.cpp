#include <wayfare/match/registration.hpp>

#include <algorithm>
#include <cmath>
#include <vector>

#include <wayfare/core/statistics.hpp>

#include "match/local/registration.hpp"

namespace wayfare {
namespace {

using detail::Cost;

/// A point and its line.
struct Pair {
  Eigen::Vector2d point;   ///< in the scan's own axes
  Eigen::Vector2d normal;  ///< in the map's
  double offset = 0.0;     ///< normal · q, q on the line
  double distance = 0.0;   ///< from q at the time of pairing

  [[nodiscard]] double residual(const SE2d& pose) const {
    return normal.dot(pose * point) - offset;
  }
  /// ∂residual/∂ξ.
  [[nodiscard]] Eigen::Vector3d gradient(const SE2d& pose) const {
    const Eigen::Vector2d n = pose.rotation().inverse() * normal;
    return {n.x(), n.y(), point.x() * n.y() - point.y() * n.x()};
  }
};

std::vector<Pair> pairs_at(const SurfaceMap& map, const PointSet& points, const SE2d& pose,
                           double max_distance_m) {
  std::vector<Pair> pairs;
  pairs.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector2d p = points[i].cast<double>();
    const Eigen::Vector2f at = (pose * p).cast<float>();
    const SurfacePoint* s = map.nearest(at, static_cast<float>(max_distance_m));
    if (s == nullptr || s->normal.isZero(0)) continue;
    const Eigen::Vector2d n = s->normal.cast<double>();
    pairs.push_back(
        {p, n, n.dot(s->point.cast<double>()), static_cast<double>((s->point - at).norm())});
  }
  return pairs;
}

/// Cauchy kernel: ½ Σ ln(1 + r²/σ²), with the weights 1/(1 + r²/σ²) in the Hessian.
Cost cost_of(const std::vector<Pair>& pairs, const SE2d& pose, double sigma_m, double weight) {
  const double information = 1 / (sigma_m * sigma_m);
  Cost cost;
  for (const Pair& pair : pairs) {
    const double r = pair.residual(pose);
    const double w = weight * information / (1 + r * r * information);
    const Eigen::Vector3d g = pair.gradient(pose);
    cost.value += 0.5 * weight * std::log1p(r * r * information);
    cost.negative_gradient -= w * r * g;
    cost.hessian += w * g * g.transpose();
  }
  return cost;
}

/// Σ of the gradients' outer products over pairs, and the fit of all points.
struct IcpFit {
  Eigen::Matrix3d outer = Eigen::Matrix3d::Zero();
  double mean_log_likelihood = 0.0;
};

IcpFit fit_at(const SurfaceMap& map, const PointSet& points, const SE2d& pose,
              const IcpOptions& options) {
  const double log_floor = std::log(options.floor_probability);
  const double reach = options.sigma_m * std::sqrt(-2 * log_floor);
  IcpFit fit;
  const std::vector<Pair> pairs = pairs_at(map, points, pose, reach);
  for (const Pair& pair : pairs) {
    const double sigmas = pair.residual(pose) / options.sigma_m;
    const Eigen::Vector3d g = pair.gradient(pose);
    fit.outer += g * g.transpose();
    fit.mean_log_likelihood += std::max(log_floor, -0.5 * sigmas * sigmas) - log_floor;
  }
  fit.mean_log_likelihood =
      log_floor + fit.mean_log_likelihood / static_cast<double>(points.size());
  return fit;
}

}  // namespace

Result<std::optional<MatchResult>> IcpMatcher::match(const SurfaceMap& map, const PointSet& points,
                                                     const SE2d& prior, const SearchWindow& window,
                                                     const MatchOptions& options) const {
  if (!(options_.sigma_m > 0) || !(options_.max_correspondence_m > 0) ||
      !(options_.floor_probability > 0 && options_.floor_probability < 1))
    return Error{ErrorCode::invalid, "ICP: sigma, reach or floor out of range"};
  if (map.empty()) return Error{ErrorCode::invalid, "ICP: the map is empty"};
  if (auto ok = detail::check_input("ICP", points, prior, window, options); !ok) return ok.error();
  const detail::Prior prior_term(prior, window, options, points);
  const double min_reach = 5 * options_.sigma_m;
  SE2d pose = prior;
  double reach = options_.max_correspondence_m;
  std::vector<Pair> pairs;
  for (int i = 0; i < options_.max_iterations; ++i) {
    pairs = pairs_at(map, points, pose, reach);
    if (pairs.size() < 3) return std::optional<MatchResult>();
    // Far from the solution, residuals are scaled by their median; close to it, by the noise.
    const double median = upper_median_of(pairs, &Pair::distance);
    const double sigma = std::max(options_.sigma_m, median);
    const SE2d before = pose;
    const auto cost_at = [&](const SE2d& at) {
      return cost_of(pairs, at, sigma, prior_term.weight());
    };
    prior_term.minimise(pose, cost_at, 3, options_.tolerance);
    const double wanted = std::max(min_reach, 3 * median);
    const bool converged = before.minus(pose).norm() < options_.tolerance && wanted >= 0.7 * reach;
    reach = std::min(reach, wanted);
    if (converged) break;
  }
  const IcpFit fit = fit_at(map, points, pose, options_);
  return prior_term.match({pose, fit.mean_log_likelihood,
                           1 - fit.mean_log_likelihood / std::log(options_.floor_probability),
                           1 / (options_.sigma_m * options_.sigma_m), [&] { return fit.outer; }});
}

}  // namespace wayfare
