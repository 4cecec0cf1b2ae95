#include <wayfare/map/ndt_map.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "map/kernels/kernels.hpp"
#include "map/point_sums.hpp"

namespace wayfare {
namespace {

/// Values of a packed distribution, see kernels::NdtTable.
constexpr std::size_t kPacked = 8;

/// The covariance's eigenvalues are at least min_sigma_m².
NdtCell distribution(const detail::Moments& m, const NdtMapOptions& options) {
  NdtCell cell;
  if (m.n < options.min_points) return cell;
  cell.mean = m.sum / m.n;
  const Eigen::Matrix2d c = m.squares / m.n - cell.mean * cell.mean.transpose();
  const detail::PrincipalAxes axes = detail::principal_axes(c);
  const double least = options.min_sigma_m * options.min_sigma_m;
  const Eigen::Vector2d u(std::cos(axes.angle), std::sin(axes.angle)), v(-u.y(), u.x());
  cell.information = u * u.transpose() / std::max(least, axes.along) +
                     v * v.transpose() / std::max(least, axes.across);
  cell.known = true;
  return cell;
}

Result<void> check(const PointSet& points, const NdtMapOptions& options) {
  constexpr double kMaxCells = 1 << 24;
  const double extent = 2 * static_cast<double>(points.max_norm_m());
  if (options.cell_sizes_m.empty() || !(options.min_sigma_m >= 1e-6) || options.min_points < 1)
    return Error{ErrorCode::invalid,
                 "an NDT map: no cell sizes, or min_sigma_m or min_points out of range"};
  for (const double side : options.cell_sizes_m) {
    const double across = extent / side + 3;
    if (!(side > 0) || !(across * across <= kMaxCells))
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
  const auto squares = static_cast<std::size_t>(box_.grown(1).cells());
  cells_.emplace_back();
  packed_.assign(kPacked, 0.0F);
  for (int t = 0; t < kTilings; ++t) {
    // Most squares have no points.
    std::vector<detail::Moments> moments(1);
    std::vector<Cell> corners(1);
    std::vector<std::int32_t>& places = places_.emplace_back(squares, 0);
    for (std::size_t i = 0; i < points_map.size(); ++i) {
      const Eigen::Vector2d p = point(i);
      const Cell square = cell_of(p + shift(t), cell_m);
      std::int32_t& in = places[place(square)];
      if (in == 0) {
        in = static_cast<std::int32_t>(moments.size());
        moments.emplace_back();
        corners.push_back(square);
      }
      moments[static_cast<std::size_t>(in)].add(p);
    }
    std::vector<std::int32_t> stored(1);  // of each of the moments
    for (std::size_t m = 1; m < moments.size(); ++m) {
      const NdtCell cell = distribution(moments[m], options);
      stored.push_back(cell.known ? static_cast<std::int32_t>(cells_.size()) : 0);
      if (!cell.known) continue;
      cells_.push_back(cell);
      const Eigen::Vector2d in_square =
          (cell.mean + shift(t)) / cell_m - Eigen::Vector2d(corners[m].x, corners[m].y);
      const Eigen::Matrix2d information = cell.information * cell_m * cell_m;
      for (const double v : {in_square.x(), in_square.y(), information(0, 0), information(0, 1),
                             information(1, 1), 1.0, 0.0, 0.0})
        packed_.push_back(static_cast<float>(v));
    }
    for (std::int32_t& in : places) in = stored[static_cast<std::size_t>(in)];
  }
}

NdtMap::Sums NdtMap::Level::sums(const PointSet& points, const SE2d& T_map_points) const {
  // Squares from the corner of the one the pose is in, so that rounding does not grow with the map.
  const Eigen::Vector2d origin = T_map_points.translation() / cell_m_;
  const Cell square = cell_of(T_map_points.translation(), cell_m_);
  const SO2d& rotation = T_map_points.rotation();
  const kernels::CellTransform transform{static_cast<float>(rotation.cos() / cell_m_),
                                         static_cast<float>(rotation.sin() / cell_m_),
                                         static_cast<float>(origin.x() - square.x),
                                         static_cast<float>(origin.y() - square.y),
                                         static_cast<float>(1 << 22),
                                         square.x - box_.min.x,
                                         square.y - box_.min.y};
  const kernels::NdtTable table{
      {places_[0].data(), places_[1].data(), places_[2].data(), places_[3].data()},
      packed_.data(),
      static_cast<int>(box_.width()),
      static_cast<int>(box_.height())};
  double s[10];
  kernels::best_kernels().ndt_sums(points.padded_x_m().data(), points.padded_y_m().data(),
                                   static_cast<int>(points.size()), transform, table, s);
  const double per_m = 1 / cell_m_, per_m2 = per_m * per_m;
  Sums sums;
  sums.likelihood = s[0];
  sums.pull << s[1] * per_m, s[2] * per_m, s[3];
  sums.hessian << s[4] * per_m2, s[5] * per_m2, s[7] * per_m,  //
      s[5] * per_m2, s[6] * per_m2, s[8] * per_m,              //
      s[7] * per_m, s[8] * per_m, s[9];
  return sums;
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
