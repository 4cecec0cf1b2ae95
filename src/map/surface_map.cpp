#include <wayfare/map/surface_map.hpp>

#include <algorithm>
#include <cmath>
#include <numeric>

#include <wayfare/map/voxel_filter.hpp>

#include "map/placed_points.hpp"

namespace wayfare {
namespace {

constexpr std::int64_t kMaxBuckets = std::int64_t{1} << 26;

/// Normal of the line fit to points with this scatter about their mean.
Eigen::Vector2f normal_of(const Eigen::Matrix2d& scatter, double max_flatness) {
  const double half_trace = 0.5 * scatter.trace();
  const double spread = std::hypot(0.5 * (scatter(0, 0) - scatter(1, 1)), scatter(0, 1));
  const double across = half_trace - spread, along = half_trace + spread;
  if (!(along > 0) || across > max_flatness * max_flatness * along) return Eigen::Vector2f::Zero();
  const double angle = 0.5 * std::atan2(2 * scatter(0, 1), scatter(0, 0) - scatter(1, 1));
  return Eigen::Vector2d(-std::sin(angle), std::cos(angle)).cast<float>();
}

}  // namespace

Result<SurfaceMap> SurfaceMap::make(std::span<const PlacedPoints> scans,
                                    const SurfaceMapOptions& options) {
  if (!(options.normal_radius_m > 0 && options.normal_radius_m <= 10))
    return Error{ErrorCode::invalid, "a surface map: the normals' radius is out of range"};
  const auto all = detail::placed_points(scans, "a surface map");
  if (!all) return all.error();
  const auto points = voxel_filter(*all, options.spacing_m);
  if (!points) return points.error();
  SurfaceMap map;
  const auto cell = [&](std::size_t i) { return cell_of((*points)[i].cast<double>(), kBucket_m); };
  map.box_ = {cell(0), cell(0)};
  for (std::size_t i = 0; i < points->size(); ++i) map.box_.extend(cell(i));
  if (map.box_.width() > kMaxBuckets / map.box_.height())
    return Error{ErrorCode::invalid, "a surface map: the points are too far apart"};
  map.sort_into_buckets(*points);
  map.find_normals(options);
  return map;
}

/// Stable counting sort.
void SurfaceMap::sort_into_buckets(const PointSet& points) {
  first_.assign(static_cast<std::size_t>(box_.cells()) + 1, 0);
  std::vector<std::size_t> bucket_of(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    bucket_of[i] = box_.index(cell_of(points[i].cast<double>(), kBucket_m));
    ++first_[bucket_of[i] + 1];
  }
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  points_.resize(points.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    points_[next[bucket_of[i]]++] = {points[i], Eigen::Vector2f::Zero()};
}

void SurfaceMap::find_normals(const SurfaceMapOptions& options) {
  const auto radius = static_cast<float>(options.normal_radius_m);
  for (SurfacePoint& s : points_) {
    double n = 0;
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();
    for_each_within(s.point, radius, [&](const SurfacePoint& other) {
      const Eigen::Vector2d d = (other.point - s.point).cast<double>();
      n += 1;
      sum += d;
      squares += d * d.transpose();
    });
    if (n >= 3)
      s.normal = normal_of(squares / n - sum * sum.transpose() / (n * n), options.max_flatness);
  }
}

CellBox SurfaceMap::buckets_within(const Eigen::Vector2f& p, float radius_m) const {
  const Eigen::Vector2d centre = p.cast<double>();
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant(static_cast<double>(radius_m));
  const Cell low = cell_of(centre - margin, kBucket_m), high = cell_of(centre + margin, kBucket_m);
  return {{std::max(low.x, box_.min.x), std::max(low.y, box_.min.y)},
          {std::min(high.x, box_.max.x), std::min(high.y, box_.max.y)}};
}

const SurfacePoint* SurfaceMap::nearest(const Eigen::Vector2f& p_map, float radius_m) const {
  const SurfacePoint* best = nullptr;
  float square = radius_m * radius_m;
  // The nearest point is usually close, so a small radius is searched first.
  for (const float radius : {std::min(radius_m, 0.25F), radius_m}) {
    for_each_within(p_map, radius, [&](const SurfacePoint& s) {
      const float d = (s.point - p_map).squaredNorm();
      if (d < square || (best == nullptr && d <= square)) {
        square = d;
        best = &s;
      }
    });
    if (best != nullptr) break;
  }
  return best;
}

}  // namespace wayfare
