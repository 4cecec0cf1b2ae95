#include "match/local/registration.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include <wayfare/map/surface_map.hpp>

namespace wayfare::detail {

Result<void> check_input(std::string_view who, const PointSet& points, const SE2d& prior,
                         const SearchWindow& window, const MatchOptions& options) {
  const auto refused = [&](const char* why) {
    return Error{ErrorCode::invalid, std::string(who) + ": " + why};
  };
  if (points.empty()) return refused("no points");
  int bad = 0;
  for (const auto& axis : {points.x_m(), points.y_m()})
    for (const float t : axis) bad |= !(std::abs(t) <= std::numeric_limits<float>::max());
  if (bad != 0) return refused("a point is not finite");
  if (!prior.translation().allFinite() || !std::isfinite(prior.heading().radians()))
    return refused("the initial pose is not finite");
  if (!(window.half_x_m >= 0 && window.half_y_m >= 0 && window.half_heading.radians() >= 0))
    return refused("the window's half extents must not be negative");
  if (std::isnan(options.min_score) || std::isnan(options.independent_points))
    return refused("min_score or independent_points is not a number");
  if (!options.prior_information) return {};
  const Eigen::Matrix3d symmetric =
      0.5 * (*options.prior_information + options.prior_information->transpose());
  const double norm = symmetric.norm();
  if (!std::isfinite(norm)) return refused("the prior's information is not finite");
  if (Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(symmetric, Eigen::EigenvaluesOnly)
          .eigenvalues()[0] < -1e-9 * norm)
    return refused("the prior's information matrix is indefinite");
  return {};
}

Prior::Prior(const SE2d& prior, const SearchWindow& window, const MatchOptions& options,
             const PointSet& points)
    : prior_(prior),
      window_(window),
      options_(options),
      points_(points),
      weight_(options.independent_points > 0
                  ? std::min(1.0, options.independent_points / static_cast<double>(points.size()))
                  : 1.0) {}

std::optional<MatchResult> Prior::match(const Solution& solution) const {
  if (!in_window(solution.pose) || solution.score < options_.min_score) return std::nullopt;
  MatchResult result;
  result.T_map_points = solution.pose;
  result.mean_log_likelihood = solution.mean_log_likelihood;
  result.score = solution.score;
  if (options_.covariance) {
    const Eigen::Matrix3d outer = solution.outer();
    result.covariance = covariance(weight_ * solution.information * outer);
    result.constraint = SceneConstraint::of(outer, rms_distance_m(points_));
  }
  return result;
}

/// The offset is d = (R₀ᵀ(t − t₀), θ − θ₀); a step ξ in the pose's own axes changes it by A ξ.
void Prior::add(const SE2d& pose, Cost& cost) const {
  if (!options_.prior_information) return;
  const Eigen::Matrix3d& information = *options_.prior_information;
  const SO2d rotation = prior_.rotation().inverse() * pose.rotation();
  Eigen::Vector3d d;
  d << prior_.rotation().inverse() * Eigen::Vector2d(pose.translation() - prior_.translation()),
      rotation.angle().radians();
  Eigen::Matrix3d A = Eigen::Matrix3d::Identity();
  A.topLeftCorner<2, 2>() = rotation.matrix();
  const Eigen::Matrix3d weighted = A.transpose() * information;
  cost.value += 0.5 * d.dot(information * d);
  cost.negative_gradient -= weighted * d;
  cost.hessian += weighted * A;
}

bool Prior::in_window(const SE2d& pose) const {
  const Eigen::Vector2d d = pose.translation() - prior_.translation();
  const double dtheta = (prior_.rotation().inverse() * pose.rotation()).angle().radians();
  return std::abs(d.x()) <= window_.half_x_m && std::abs(d.y()) <= window_.half_y_m &&
         std::abs(dtheta) <= window_.half_heading.radians();
}

Eigen::Matrix3d Prior::covariance(const Eigen::Matrix3d& information) const {
  // Wider windows add less than rounding leaves of the information.
  constexpr double kLeast = 1e-6, kMost = 1e3;
  const double x = std::clamp(std::max(window_.half_x_m, window_.half_y_m), kLeast, kMost);
  const double heading = std::clamp(window_.half_heading.radians(), kLeast, kMost);
  Eigen::Matrix3d bounded = information;
  bounded.diagonal() += Eigen::Vector3d(1 / (x * x), 1 / (x * x), 1 / (heading * heading));
  return bounded.inverse();
}

double rms_distance_m(const PointSet& points) {
  double sum = 0;
  for (std::size_t i = 0; i < points.size(); ++i)
    sum += static_cast<double>(points[i].squaredNorm());
  return std::sqrt(sum / static_cast<double>(points.size()));
}

Eigen::Matrix3d normals_outer(const PointSet& points, const SE2d& T_map_points,
                              const PointWeight& weight) {
  Eigen::Matrix3d outer = Eigen::Matrix3d::Zero();
  const PlacedPoints alone{&points, SE2d()};
  // With a smaller radius, a centimetre of noise rotates normals enough to constrain a corridor.
  const SurfaceMapOptions one_scan{
      .normal_radius_m = 0.3, .max_normal_radius_m = 0.3, .by_density = false};
  const auto surface = SurfaceMap::make({&alone, 1}, one_scan);
  if (!surface) return outer;
  for (const SurfacePoint& s : surface->points()) {
    const Eigen::Vector2d p = s.point.cast<double>(), n = s.normal.cast<double>();
    if (n.isZero(0)) continue;
    const Eigen::Vector3d g(n.x(), n.y(), p.x() * n.y() - p.y() * n.x());
    outer += weight(T_map_points * p, T_map_points.rotation() * n) * g * g.transpose();
  }
  // Scaled to the number of points: the surface has fewer where they are dense.
  return outer * static_cast<double>(points.size()) / static_cast<double>(surface->points().size());
}

}  // namespace wayfare::detail
