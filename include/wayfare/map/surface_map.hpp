#pragma once

// Surface points of scans, with normals.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/result.hpp>
#include <wayfare/map/cell.hpp>
#include <wayfare/map/likelihood_field.hpp>
#include <wayfare/sensors/point_set.hpp>

namespace wayfare {

/// Filter and normals of a SurfaceMap.
struct SurfaceMapOptions {
  /// Side of the voxel filter's squares, m.
  double spacing_m = 0.03;
  /// A point's normal is that of a line fit to the points within this radius, m.
  double normal_radius_m = 0.15;
  /// Where they form no line the radius is doubled, to at most this, m: a wall seen by many scans,
  /// each with the error of its pose, is a band of that thickness.
  double max_normal_radius_m = 0.6;
  /// A square counts in the fit by its number of points. Otherwise all count alike: the farthest
  /// outliers of many scans then widen the band without bound.
  bool by_density = true;
  /// Largest ratio of the standard deviations across and along the fitted line. Above it a point
  /// has no normal: ends, corners, clutter.
  double max_flatness = 0.35;
};

/// A surface point, map coordinates in metres; `normal` is a unit vector, or zero if its
/// neighbours do not form a line.
struct SurfacePoint {
  Eigen::Vector2f point,  ///< m, map coordinates
      normal;             ///< unit vector, or zero
};

/// Points of scans with normals, and nearest-neighbour search among them.
class SurfaceMap {
 public:
  SurfaceMap() = default;

  /// Errors: no points, points or poses that are not finite, points too far apart (more than 2²⁶
  /// squares of 25 cm, or 1e7 m from the origin), options out of range.
  [[nodiscard]] static Result<SurfaceMap> make(std::span<const PlacedPoints> scans,
                                               const SurfaceMapOptions& options = {});

  /// All surface points.
  [[nodiscard]] std::span<const SurfacePoint> points() const { return points_; }
  /// Whether it has no points.
  [[nodiscard]] bool empty() const { return points_.empty(); }
  /// The nearest point, or null if none is within `radius_m`; none is within a negative radius.
  [[nodiscard]] const SurfacePoint* nearest(const Eigen::Vector2f& p_map, float radius_m) const;
  /// The same for points that move little from call to call.
  class Tracker;
  /// visit(point) for every point within `radius_m`.
  template <class Visit>
  void for_each_within(const Eigen::Vector2f& p_map, float radius_m, const Visit& visit) const;

 private:
  static constexpr double kBucket_m = 0.25;

  /// Returns each point's place among points_.
  std::vector<std::size_t> sort_into_buckets(const PointSet& points);
  /// `weights`: of points_; empty: all alike.
  void find_normals(const SurfaceMapOptions& options, std::span<const double> weights);
  [[nodiscard]] Eigen::Vector2f normal_at(const Eigen::Vector2f& point, float radius_m,
                                          double max_flatness,
                                          std::span<const double> weights) const;
  [[nodiscard]] CellBox buckets_within(const Eigen::Vector2f& p, float radius_m) const;
  [[nodiscard]] std::span<const SurfacePoint> bucket(const Cell& c) const {
    const std::size_t i = box_.index(c);
    return {points_.data() + first_[i], first_[i + 1] - first_[i]};
  }

  CellBox box_{{0, 0}, {-1, -1}};     // of buckets
  std::vector<std::uint32_t> first_;  // point of each bucket, row-major, and the end
  std::vector<SurfacePoint> points_;  // bucket by bucket
  std::vector<float> x_, y_;          // of the points; some more follow
};

/// The nearest surface points of points that move little from call to call: searched only where the
/// answer could have changed. The map must outlive it.
class SurfaceMap::Tracker {
 public:
  /// For `n` points.
  Tracker(const SurfaceMap& map, std::size_t n);

  /// Of each of the n points.
  struct Nearest {
    std::span<const std::int32_t> index;  ///< among the map's points, −1 for none
    std::span<const float> squared_m2;    ///< distances, m²
  };
  /// The nearest points within `radius_m`, valid until the next call. Points farther than 10⁸ m
  /// from the map's origin, or that are not numbers, have none.
  [[nodiscard]] Nearest nearest(std::span<const float> x_map, std::span<const float> y_map,
                                float radius_m);

 private:
  const SurfaceMap& map_;
  std::size_t n_;
  std::vector<float> x_, y_;  // padded
  std::vector<float> searched_x_, searched_y_, nearest_x_, nearest_y_, others_, squared_m2_;
  std::vector<std::int32_t> known_, index_;
};

template <class Visit>
void SurfaceMap::for_each_within(const Eigen::Vector2f& p_map, float radius_m,
                                 const Visit& visit) const {
  const CellBox near = buckets_within(p_map, radius_m);
  for (int y = near.min.y; y <= near.max.y; ++y)
    for (int x = near.min.x; x <= near.max.x; ++x)
      for (const SurfacePoint& s : bucket({x, y}))
        if ((s.point - p_map).squaredNorm() <= radius_m * radius_m) visit(s);
}

}  // namespace wayfare
