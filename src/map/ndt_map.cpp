#include <wayfare/map/ndt_map.hpp>

#include <algorithm>
#include <cmath>
#include <string>

#include "map/placed_points.hpp"

namespace wayfare {
namespace {

constexpr std::int64_t kMaxCells = std::int64_t{1} << 24;

struct Moments {
  double n = 0;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();
};

/// The covariance's eigenvalues are at least min_sigma_m².
NdtCell distribution(const Moments& m, const NdtMapOptions& options) {
  NdtCell cell;
  if (m.n < options.min_points) return cell;
  cell.mean = m.sum / m.n;
  const Eigen::Matrix2d c = m.squares / m.n - cell.mean * cell.mean.transpose();
  const double half_trace = 0.5 * c.trace();
  const double spread = std::hypot(0.5 * (c(0, 0) - c(1, 1)), c(0, 1));
  const double angle = 0.5 * std::atan2(2 * c(0, 1), c(0, 0) - c(1, 1));
  const double least = options.min_sigma_m * options.min_sigma_m;
  const double along = std::max(least, half_trace + spread);
  const double across = std::max(least, half_trace - spread);
  const Eigen::Vector2d u(std::cos(angle), std::sin(angle)), v(-u.y(), u.x());
  cell.information = u * u.transpose() / along + v * v.transpose() / across;
  cell.known = true;
  return cell;
}

Result<void> check(const PointSet& points, const NdtMapOptions& options) {
  const double extent = 2 * static_cast<double>(points.max_norm_m());
  if (options.cell_sizes_m.empty() || !(options.min_sigma_m > 0))
    return Error{ErrorCode::invalid, "an NDT map: no cell sizes, or min_sigma_m is not positive"};
  for (const double side : options.cell_sizes_m) {
    const double across = extent / side + 3;
    if (!(side > 0) || !(across * across <= static_cast<double>(kMaxCells)))
      return Error{ErrorCode::invalid,
                   "an NDT map: cells of " + std::to_string(side) + " m cannot cover the points"};
  }
  return {};
}

}  // namespace

NdtMap::Level::Level(const PointSet& points_map, double cell_m, const NdtMapOptions& options)
    : cell_m_(cell_m) {
  const auto point = [&](std::size_t i) { return Eigen::Vector2d(points_map[i].cast<double>()); };
  box_ = {cell_of(point(0), cell_m), cell_of(point(0), cell_m)};
  for (std::size_t i = 0; i < points_map.size(); ++i)
    for (int t = 0; t < kTilings; ++t) box_.extend(cell_of(point(i) + shift(t), cell_m));
  const auto cells = static_cast<std::size_t>(box_.cells());
  for (int t = 0; t < kTilings; ++t) {
    std::vector<Moments> moments(cells);
    for (std::size_t i = 0; i < points_map.size(); ++i) {
      const Eigen::Vector2d p = point(i);
      Moments& m = moments[box_.index(cell_of(p + shift(t), cell_m))];
      m.n += 1;
      m.sum += p;
      m.squares += p * p.transpose();
    }
    std::vector<NdtCell>& tiling = tilings_.emplace_back();
    for (const Moments& m : moments) tiling.push_back(distribution(m, options));
  }
}

Result<NdtMap> NdtMap::make(std::span<const PlacedPoints> scans, const NdtMapOptions& options) {
  const auto points = detail::placed_points(scans, "an NDT map");
  if (!points) return points.error();
  if (auto ok = check(*points, options); !ok) return ok.error();
  NdtMap map;
  for (const double side : options.cell_sizes_m) map.levels_.emplace_back(*points, side, options);
  return map;
}

}  // namespace wayfare
