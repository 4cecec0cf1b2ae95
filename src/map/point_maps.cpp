// Maps made of the points of scans: voxel filter, surfaces with normals, normal distributions.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include <wayfare/map/point_maps.hpp>

namespace wayfare {
namespace {

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
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double points = 0.0;
};

/// In the order of their first points. Errors as of voxel_filter.
Result<std::vector<Square>> squares_of(const PointSet& points, double side_m) {
  if (!(side_m > 0 && std::isfinite(side_m)))
    return Error{ErrorCode::invalid, "voxel_filter: the side must be positive"};
  std::vector<Square> squares;
  std::unordered_map<std::int64_t, std::size_t> square_at;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector2d p = points[i].cast<double>();
    const Cell c = cell_of(p, side_m);
    if (!p.allFinite() || std::abs(c.x) >= kMaxCell || std::abs(c.y) >= kMaxCell)
      return Error{ErrorCode::invalid, "voxel_filter: a point is not finite, or too far"};
    const std::int64_t key = std::int64_t{c.y} * (std::int64_t{1} << 32) + c.x;
    const auto [entry, is_new] = square_at.try_emplace(key, squares.size());
    if (is_new) squares.emplace_back();
    Square& square = squares[entry->second];
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

NdtMap::Level::Level(const PointSet& points_map, double cell_m, const NdtMapOptions& options)
    : cell_m_(cell_m) {
  const auto point = [&](std::size_t i) { return Eigen::Vector2d(points_map[i].cast<double>()); };
  box_ = {cell_of(point(0), cell_m), cell_of(point(0), cell_m)};
  for (std::size_t i = 0; i < points_map.size(); ++i)
    for (int t = 0; t < kTilings; ++t) box_.extend(cell_of(point(i) + shift(t), cell_m));
  const auto cells = static_cast<std::size_t>(box_.cells());
  for (int t = 0; t < kTilings; ++t) {
    // Most squares have no points.
    std::vector<Moments> moments;
    std::vector<std::uint32_t>& places = places_.emplace_back(cells, kNone);
    for (std::size_t i = 0; i < points_map.size(); ++i) {
      const Eigen::Vector2d p = point(i);
      std::uint32_t& place = places[box_.index(cell_of(p + shift(t), cell_m))];
      if (place == kNone) {
        place = static_cast<std::uint32_t>(moments.size());
        moments.emplace_back();
      }
      moments[place].add(p);
    }
    std::vector<std::uint32_t> stored;  // of each of the moments
    for (const Moments& m : moments) {
      const NdtCell cell = distribution(m, options);
      stored.push_back(cell.known ? static_cast<std::uint32_t>(cells_.size()) : kNone);
      if (cell.known) cells_.push_back(cell);
    }
    for (std::uint32_t& place : places)
      if (place != kNone) place = stored[place];
  }
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
