// Maps made of the points of scans: voxel filter, surfaces with normals, normal distributions.

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <wayfare/core/contract.hpp>
#include <wayfare/map/point_maps.hpp>

#include "map/kernels/kernels.hpp"

namespace wayfare {
namespace {

/// Values of a packed distribution, see kernels::NdtTable.
constexpr std::size_t kPacked = 8;

/// All points in the map frame. Errors: no points, a point that is not finite or too far away.
/// `what` is the map to be built, for the messages.
Result<PointSet> placed_points(std::span<const PlacedPoints> scans, std::string_view what) {
  PointSet points;
  for (const PlacedPoints& scan : scans) {
    if (scan.points == nullptr)
      return Error{ErrorCode::invalid, std::string(what) + ": a pose without points"};
    for (std::size_t i = 0; i < scan.points->size(); ++i) {
      const Eigen::Vector2d p =
          scan.T_map_points * Eigen::Vector2d((*scan.points)[i].cast<double>());
      if (!(p.cwiseAbs().maxCoeff() < 1e7))
        return Error{ErrorCode::invalid,
                     std::string(what) + ": a point or pose is not finite, or too far"};
      points.push_back(p.cast<float>());
    }
  }
  if (points.empty()) return Error{ErrorCode::invalid, std::string(what) + ": no points"};
  return points;
}

/// Variances along and across the principal direction of a covariance, and its angle.
struct PrincipalAxes {
  double along, across, angle;
};

PrincipalAxes principal_axes(const Eigen::Matrix2d& c) {
  const double half_trace = 0.5 * c.trace();
  const double spread = std::hypot(0.5 * (c(0, 0) - c(1, 1)), c(0, 1));
  return {half_trace + spread, half_trace - spread,
          0.5 * std::atan2(2 * c(0, 1), c(0, 0) - c(1, 1))};
}

/// Normal of the line fit to points with this scatter about their mean.
Eigen::Vector2f normal_of(const Eigen::Matrix2d& scatter, double max_flatness) {
  const auto [along, across, angle] = principal_axes(scatter);
  if (!(along > 0) || across > max_flatness * max_flatness * along) return Eigen::Vector2f::Zero();
  return Eigen::Vector2d(-std::sin(angle), std::cos(angle)).cast<float>();
}

struct Moments {
  double n = 0;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();

  void add(const Eigen::Vector2d& p, double weight = 1.0) {
    n += weight;
    sum += weight * p;
    squares += weight * p * p.transpose();
  }
};

/// The covariance's eigenvalues are at least min_sigma_m².
NdtCell distribution(const Moments& m, const NdtMapOptions& options) {
  NdtCell cell;
  if (m.n < options.min_points) return cell;
  cell.mean = m.sum / m.n;
  const Eigen::Matrix2d c = m.squares / m.n - cell.mean * cell.mean.transpose();
  const PrincipalAxes axes = principal_axes(c);
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

/// The points of a square.
struct Square {
  Cell at;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double points = 0.0;
};

/// In the order of their first points. Errors as of voxel_filter.
Result<std::vector<Square>> squares_of(const PointSet& points, double side_m) {
  if (!(side_m > 0 && std::isfinite(side_m)))
    return Error{ErrorCode::invalid, "voxel_filter: the side must be positive"};
  std::vector<Square> squares;
  squares.reserve(points.size());
  // Open addressing with linear probing, at most half full: numbers of squares, from 1.
  std::vector<std::uint32_t> table(std::bit_ceil(2 * points.size() + 1));
  const auto entry_of = [&](const Cell& c) -> std::uint32_t& {
    const std::uint64_t key =
        std::uint64_t{static_cast<std::uint32_t>(c.y)} << 32 | static_cast<std::uint32_t>(c.x);
    auto i = static_cast<std::size_t>((key * 0x9e3779b97f4a7c15ULL) >> 32);
    for (;; ++i) {
      std::uint32_t& entry = table[i & (table.size() - 1)];
      if (entry == 0 || squares[entry - 1].at == c) return entry;
    }
  };
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector2d p = points[i].cast<double>();
    const Cell c = cell_of(p, side_m);
    if (!p.allFinite() || std::abs(c.x) >= kMaxCell || std::abs(c.y) >= kMaxCell)
      return Error{ErrorCode::invalid, "voxel_filter: a point is not finite, or too far"};
    std::uint32_t& entry = entry_of(c);
    if (entry == 0) {
      squares.push_back({c});
      entry = static_cast<std::uint32_t>(squares.size());
    }
    Square& square = squares[entry - 1];
    square.sum += p;
    square.points += 1.0;
  }
  return squares;
}

PointSet means_of(const std::vector<Square>& squares) {
  PointSet means;
  means.reserve(squares.size());
  for (const Square& s : squares) means.push_back((s.sum / s.points).cast<float>());
  return means;
}

}  // namespace

Result<PointSet> voxel_filter(const PointSet& points, double side_m) {
  const auto squares = squares_of(points, side_m);
  if (!squares) return squares.error();
  return means_of(*squares);
}

Result<SurfaceMap> SurfaceMap::make(std::span<const PlacedPoints> scans,
                                    const SurfaceMapOptions& options) {
  if (!(options.normal_radius_m > 0 && options.normal_radius_m <= 10) ||
      !(options.max_normal_radius_m <= 10) || !(options.max_flatness >= 0))
    return Error{ErrorCode::invalid,
                 "a surface map: the normals' radius or flatness is out of range"};
  const auto all = placed_points(scans, "a surface map");
  if (!all) return all.error();
  const auto squares = squares_of(*all, options.spacing_m);
  if (!squares) return squares.error();
  const PointSet points = means_of(*squares);
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
  Moments m;
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
    std::vector<Moments> moments(1);
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
  const auto points = placed_points(scans, "an NDT map");
  if (!points) return points.error();
  if (auto ok = check(*points, options); !ok) return ok.error();
  NdtMap map;
  for (const double side : options.cell_sizes_m) map.levels_.emplace_back(*points, side, options);
  return map;
}

}  // namespace wayfare
