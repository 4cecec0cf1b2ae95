#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/result.hpp>
#include <wayfare/map/cell.hpp>
#include <wayfare/map/likelihood_field.hpp>

namespace wayfare {

struct SurfaceMapOptions {
  /// Side of the voxel filter's squares, m.
  double spacing_m = 0.03;
  /// A point's normal is that of a line fit to the points within this radius, m.
  double normal_radius_m = 0.15;
  /// Largest ratio of the standard deviations across and along the fitted line. Above it a point
  /// has no normal: ends, corners, clutter.
  double max_flatness = 0.35;
};

/// A surface point, map coordinates in metres; `normal` is a unit vector, or zero if its
/// neighbours do not form a line.
struct SurfacePoint {
  Eigen::Vector2f point, normal;
};

/// Points of scans with normals, and nearest-neighbour search among them.
class SurfaceMap {
 public:
  SurfaceMap() = default;

  /// Errors: no points, points or poses that are not finite, points too far apart (more than 2²⁶
  /// squares of 25 cm, or 1e7 m from the origin), options out of range.
  [[nodiscard]] static Result<SurfaceMap> make(std::span<const PlacedPoints> scans,
                                               const SurfaceMapOptions& options = {});

  [[nodiscard]] std::span<const SurfacePoint> points() const { return points_; }
  [[nodiscard]] bool empty() const { return points_.empty(); }
  /// The nearest point, or null if none is within `radius_m`; none is within a negative radius.
  [[nodiscard]] const SurfacePoint* nearest(const Eigen::Vector2f& p_map, float radius_m) const;
  /// visit(point) for every point within `radius_m`.
  template <class Visit>
  void for_each_within(const Eigen::Vector2f& p_map, float radius_m, const Visit& visit) const;

 private:
  static constexpr double kBucket_m = 0.25;

  void sort_into_buckets(const PointSet& points);
  void find_normals(const SurfaceMapOptions& options);
  [[nodiscard]] CellBox buckets_within(const Eigen::Vector2f& p, float radius_m) const;
  [[nodiscard]] std::span<const SurfacePoint> bucket(const Cell& c) const {
    const std::size_t i = box_.index(c);
    return {points_.data() + first_[i], first_[i + 1] - first_[i]};
  }

  CellBox box_{{0, 0}, {-1, -1}};     // of buckets
  std::vector<std::uint32_t> first_;  // point of each bucket, row-major, and the end
  std::vector<SurfacePoint> points_;  // bucket by bucket
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
