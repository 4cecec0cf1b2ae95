#include <wayfare/match/registration.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include <wayfare/core/statistics.hpp>

#include "map/kernels/kernels.hpp"
#include "match/local/registration.hpp"

namespace wayfare {
namespace {

using detail::Cost;

/// Points of a scan, each with the line through its nearest surface point.
class Pairs {
 public:
  Pairs(const SurfaceMap& map, const PointSet& points)
      : map_(map), points_(points), tracker_(map, points.size()) {
    const std::size_t n = points.size();
    for (std::vector<float>* axis : {&x_, &y_}) axis->resize(n);
    for (std::vector<float>* axis : {&px_, &py_, &qx_, &qy_, &nx_, &ny_})
      axis->resize((n + PointSet::kLanes - 1) / PointSet::kLanes * PointSet::kLanes);
    squared_m2_.resize(n);
  }

  /// The pairs at a pose.
  void find(const SE2d& pose, double max_distance_m) {
    const std::span<const float> x = points_.x_m(), y = points_.y_m();
    origin_ = pose.translation();
    const double c = pose.rotation().cos(), s = pose.rotation().sin();
    for (std::size_t i = 0; i < x.size(); ++i) {
      const double px = static_cast<double>(x[i]), py = static_cast<double>(y[i]);
      x_[i] = static_cast<float>(c * px - s * py + origin_.x());
      y_[i] = static_cast<float>(s * px + c * py + origin_.y());
    }
    const auto [nearest, squared_m2] = tracker_.nearest(x_, y_, static_cast<float>(max_distance_m));
    const std::span<const SurfacePoint> surface = map_.points();
    std::size_t n = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      if (nearest[i] < 0) continue;
      const SurfacePoint& at = surface[static_cast<std::size_t>(nearest[i])];
      px_[n] = x[i];
      py_[n] = y[i];
      qx_[n] = static_cast<float>(static_cast<double>(at.point.x()) - origin_.x());
      qy_[n] = static_cast<float>(static_cast<double>(at.point.y()) - origin_.y());
      nx_[n] = at.normal.x();
      ny_[n] = at.normal.y();
      squared_m2_[n] = squared_m2[i];
      n += at.normal.x() != 0.0F || at.normal.y() != 0.0F ? 1U : 0U;  // else overwritten
    }
    size_ = n;
    for (std::vector<float>* axis : {&px_, &py_, &qx_, &qy_, &nx_, &ny_})
      std::fill(axis->begin() + static_cast<std::ptrdiff_t>(n), axis->end(), 0.0F);
  }

  [[nodiscard]] std::size_t size() const { return size_; }
  /// The median of the distances from the nearest points, at least `least_m`.
  [[nodiscard]] double median_m(double least_m) {
    const std::span squared = std::span(squared_m2_).first(size_);
    // Near the solution most are nearer, which is counted faster than the median is found.
    const auto nearer = std::ranges::count_if(
        squared, [&](float m2) { return static_cast<double>(m2) <= least_m * least_m; });
    if (2 * static_cast<std::size_t>(nearer) > size_) return least_m;
    return std::max(least_m, std::sqrt(static_cast<double>(upper_median_of(squared))));
  }

  /// Cauchy kernel: ½ Σ ln(1 + r²/σ²), with the weights 1/(1 + r²/σ²) in the Hessian.
  [[nodiscard]] Cost cost(const SE2d& pose, double sigma_m, double weight) const {
    const double information = 1 / (sigma_m * sigma_m);
    const Eigen::Vector2d t = pose.translation() - origin_;
    const kernels::CellTransform transform{static_cast<float>(pose.rotation().cos()),
                                           static_cast<float>(pose.rotation().sin()),
                                           static_cast<float>(t.x()),
                                           static_cast<float>(t.y()),
                                           0.0F,
                                           0,
                                           0};
    const kernels::PointLines lines{px_.data(),
                                    py_.data(),
                                    qx_.data(),
                                    qy_.data(),
                                    nx_.data(),
                                    ny_.data(),
                                    static_cast<int>(size())};
    double s[10];
    kernels::best_kernels().line_squares(lines, transform, static_cast<float>(information), s);
    const double each = weight * information;
    Cost cost;
    cost.value = 0.5 * weight * s[0];
    cost.negative_gradient = -each * Eigen::Vector3d(s[1], s[2], s[3]);
    cost.hessian << s[4], s[5], s[6], s[5], s[7], s[8], s[6], s[8], s[9];
    cost.hessian *= each;
    return cost;
  }

  /// visit(residual, ∂residual/∂ξ) for every pair.
  template <class Visit>
  void for_each(const SE2d& pose, const Visit& visit) const {
    const SO2d to_scan = pose.rotation().inverse();
    for (std::size_t i = 0; i < size(); ++i) {
      const Eigen::Vector2d p = Eigen::Vector2f(px_[i], py_[i]).cast<double>();
      const Eigen::Vector2d q = origin_ + Eigen::Vector2f(qx_[i], qy_[i]).cast<double>();
      const Eigen::Vector2d normal = Eigen::Vector2f(nx_[i], ny_[i]).cast<double>();
      const Eigen::Vector2d n = to_scan * normal;
      visit(normal.dot(pose * p - q), Eigen::Vector3d(n.x(), n.y(), p.x() * n.y() - p.y() * n.x()));
    }
  }

 private:
  const SurfaceMap& map_;
  const PointSet& points_;
  Eigen::Vector2d origin_ = Eigen::Vector2d::Zero();  // of qx_, qy_
  std::vector<float> x_, y_;                          // all points in the map
  SurfaceMap::Tracker tracker_;
  std::size_t size_ = 0;  // of the pairs
  std::vector<float> px_, py_, qx_, qy_, nx_, ny_, squared_m2_;
};

/// Of all points; the pairs are those at the pose.
double mean_log_likelihood(const Pairs& pairs, std::size_t points, const SE2d& pose,
                           const IcpOptions& options) {
  const double log_floor = std::log(options.floor_probability);
  double sum = 0.0;
  pairs.for_each(pose, [&](double residual, const Eigen::Vector3d&) {
    const double sigmas = residual / options.sigma_m;
    sum += std::max(log_floor, -0.5 * sigmas * sigmas) - log_floor;
  });
  return log_floor + sum / static_cast<double>(points);
}

/// Σ of the gradients' outer products over pairs.
Eigen::Matrix3d outer_products(const Pairs& pairs, const SE2d& pose) {
  Eigen::Matrix3d outer = Eigen::Matrix3d::Zero();
  pairs.for_each(pose, [&](double, const Eigen::Vector3d& g) { outer += g * g.transpose(); });
  return outer;
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
  Pairs pairs(map, points);
  for (int i = 0; i < options_.max_iterations; ++i) {
    pairs.find(pose, reach);
    if (pairs.size() < 3) return std::optional<MatchResult>();
    // Far from the solution, residuals are scaled by their median; close to it, by the noise.
    const double sigma = pairs.median_m(options_.sigma_m);
    const SE2d before = pose;
    const auto cost_at = [&](const SE2d& at) { return pairs.cost(at, sigma, prior_term.weight()); };
    prior_term.minimise(pose, cost_at, 3, options_.tolerance);
    const double wanted = std::max(min_reach, 3 * sigma);
    const bool converged = before.minus(pose).norm() < options_.tolerance && wanted >= 0.7 * reach;
    reach = std::min(reach, wanted);
    if (converged) break;
  }
  const double log_floor = std::log(options_.floor_probability);
  pairs.find(pose, options_.sigma_m * std::sqrt(-2 * log_floor));
  const double mean = mean_log_likelihood(pairs, points.size(), pose, options_);
  return prior_term.match({pose, mean, 1 - mean / log_floor,
                           1 / (options_.sigma_m * options_.sigma_m),
                           [&] { return outer_products(pairs, pose); }});
}

}  // namespace wayfare
