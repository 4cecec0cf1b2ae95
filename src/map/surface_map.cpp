#include <wayfare/map/surface_map.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

#include <wayfare/core/contract.hpp>

#include "map/kernels/kernels.hpp"
#include "map/point_sums.hpp"

namespace wayfare {
namespace {

/// Normal of the line fit to points with this scatter about their mean.
Eigen::Vector2f normal_of(const Eigen::Matrix2d& scatter, double max_flatness) {
  const auto [along, across, angle] = detail::principal_axes(scatter);
  if (!(along > 0) || across > max_flatness * max_flatness * along) return Eigen::Vector2f::Zero();
  return Eigen::Vector2d(-std::sin(angle), std::cos(angle)).cast<float>();
}

}  // namespace

Result<SurfaceMap> SurfaceMap::make(std::span<const PlacedPoints> scans,
                                    const SurfaceMapOptions& options) {
  if (!(options.normal_radius_m > 0 && options.normal_radius_m <= 10) ||
      !(options.max_normal_radius_m <= 10) || !(options.max_flatness >= 0))
    return Error{ErrorCode::invalid,
                 "a surface map: the normals' radius or flatness is out of range"};
  const auto all = detail::placed_points(scans, "a surface map");
  if (!all) return all.error();
  const auto squares = detail::squares_of(*all, options.spacing_m);
  if (!squares) return squares.error();
  const PointSet points = detail::means_of(*squares);
  SurfaceMap map;
  const auto cell = [&](std::size_t i) { return cell_of(points[i].cast<double>(), kBucket_m); };
  map.box_ = {cell(0), cell(0)};
  for (std::size_t i = 0; i < points.size(); ++i) map.box_.extend(cell(i));
  constexpr std::int64_t kMaxBuckets = std::int64_t{1} << 26;
  if (map.box_.width() > kMaxBuckets / map.box_.height())
    return Error{ErrorCode::invalid, "a surface map: the points are too far apart"};
  const std::vector<std::size_t> places = map.sort_into_buckets(points);
  std::vector<double> weights(options.by_density ? places.size() : 0);
  for (std::size_t i = 0; i < weights.size(); ++i) weights[places[i]] = (*squares)[i].points;
  map.find_normals(options, weights);
  return map;
}

/// Stable counting sort.
std::vector<std::size_t> SurfaceMap::sort_into_buckets(const PointSet& points) {
  // first_[b + 1] is where the next point of bucket b goes, and at last where the bucket ends.
  first_.assign(static_cast<std::size_t>(box_.cells()) + 2, 0);
  std::vector<std::size_t> places(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    places[i] = box_.index(cell_of(points[i].cast<double>(), kBucket_m));
    ++first_[places[i] + 2];
  }
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  points_.resize(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    places[i] = first_[places[i] + 1]++;  // the bucket's next
    points_[places[i]] = {points[i], Eigen::Vector2f::Zero()};
  }
  constexpr std::size_t kRead = 8;  // as kernels::SurfaceTable
  x_.assign(points.size() + kRead, 0.0F);
  y_.assign(points.size() + kRead, 0.0F);
  for (std::size_t i = 0; i < points.size(); ++i) {
    x_[i] = points_[i].point.x();
    y_[i] = points_[i].point.y();
  }
  first_.pop_back();
  return places;
}

void SurfaceMap::find_normals(const SurfaceMapOptions& options, std::span<const double> weights) {
  const auto largest = static_cast<float>(options.max_normal_radius_m);
  for (SurfacePoint& s : points_) {
    auto radius = static_cast<float>(options.normal_radius_m);
    s.normal = normal_at(s.point, radius, options.max_flatness, weights);
    while (s.normal.isZero(0) && (radius *= 2) <= largest)
      s.normal = normal_at(s.point, radius, options.max_flatness, weights);
  }
}

Eigen::Vector2f SurfaceMap::normal_at(const Eigen::Vector2f& point, float radius_m,
                                      double max_flatness, std::span<const double> weights) const {
  detail::Moments m;
  int squares = 0;
  for_each_within(point, radius_m, [&](const SurfacePoint& other) {
    const Eigen::Vector2d p = (other.point - point).cast<double>();
    m.add(p, weights.empty() ? 1.0 : weights[static_cast<std::size_t>(&other - points_.data())]);
    ++squares;
  });
  if (squares < 3) return Eigen::Vector2f::Zero();
  return normal_of(m.squares / m.n - m.sum * m.sum.transpose() / (m.n * m.n), max_flatness);
}

CellBox SurfaceMap::buckets_within(const Eigen::Vector2f& p, float radius_m) const {
  if (!(radius_m >= 0)) return {{0, 0}, {-1, -1}};
  const Eigen::Vector2d centre = p.cast<double>();
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant(static_cast<double>(radius_m));
  const Cell low = cell_of(centre - margin, kBucket_m), high = cell_of(centre + margin, kBucket_m);
  return {{std::max(low.x, box_.min.x), std::max(low.y, box_.min.y)},
          {std::min(high.x, box_.max.x), std::min(high.y, box_.max.y)}};
}

const SurfacePoint* SurfaceMap::nearest(const Eigen::Vector2f& p_map, float radius_m) const {
  Tracker tracker(*this, 1);
  const std::int32_t i = tracker.nearest({&p_map.x(), 1}, {&p_map.y(), 1}, radius_m).index[0];
  return i < 0 ? nullptr : &points_[static_cast<std::size_t>(i)];
}

SurfaceMap::Tracker::Tracker(const SurfaceMap& map, std::size_t n) : map_(map), n_(n) {
  const std::size_t padded = (n + PointSet::kLanes - 1) / PointSet::kLanes * PointSet::kLanes;
  for (std::vector<float>* v :
       {&x_, &y_, &searched_x_, &searched_y_, &nearest_x_, &nearest_y_, &others_, &squared_m2_})
    v->assign(padded, 0.0F);
  known_.assign(padded, -1);
  index_.assign(padded, -1);
}

SurfaceMap::Tracker::Nearest SurfaceMap::Tracker::nearest(std::span<const float> x_map,
                                                          std::span<const float> y_map,
                                                          float radius_m) {
  static_assert(kBucket_m * kernels::kBucketsPerMetre == 1.0);
  WAYFARE_EXPECTS(x_map.size() == n_ && y_map.size() == n_, "another number of points");
  std::copy(x_map.begin(), x_map.end(), x_.begin());
  std::copy(y_map.begin(), y_map.end(), y_.begin());
  if (map_.empty() || !(radius_m >= 0)) {
    std::fill(index_.begin(), index_.end(), -1);
    return {std::span(index_).first(n_), std::span(squared_m2_).first(n_)};
  }
  const CellBox& box = map_.box_;
  const kernels::SurfaceTable table{map_.x_.data(),
                                    map_.y_.data(),
                                    map_.first_.data(),
                                    box.min.x,
                                    box.min.y,
                                    static_cast<int>(box.width()),
                                    static_cast<int>(box.height())};
  const kernels::Neighbours known{searched_x_.data(), searched_y_.data(), known_.data(),
                                  nearest_x_.data(),  nearest_y_.data(),  others_.data()};
  kernels::best_kernels().nearest(table, x_.data(), y_.data(), static_cast<int>(n_), radius_m,
                                  known, index_.data(), squared_m2_.data());
  return {std::span(index_).first(n_), std::span(squared_m2_).first(n_)};
}

}  // namespace wayfare
