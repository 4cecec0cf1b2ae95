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
  /// Points within a square of this side are taken together, m.
  double spacing_m = 0.03;
  /// A point's normal is that of the line through the points within this radius, m.
  double normal_radius_m = 0.15;
  /// Points about which the others lie less like a line than this (ratio of the standard deviations
  /// across and along it) have no normal: ends, corners, clutter.
  double max_flatness = 0.35;
};

/// A point of a wall, map coordinates in metres; `normal` is a unit vector, or zero where the
/// points about it are not like a line.
struct SurfacePoint {
  Eigen::Vector2f point, normal;
};

/// Points of what scans saw, with normals, and the nearest of them to any place.
class SurfaceMap {
 public:
  SurfaceMap() = default;

  /// Refused: no point, points or poses that are not finite, points too far apart to be held.
  [[nodiscard]] static Result<SurfaceMap> make(std::span<const PlacedPoints> scans,
                                               const SurfaceMapOptions& options = {});

  [[nodiscard]] std::span<const SurfacePoint> points() const { return points_; }
  [[nodiscard]] bool empty() const { return points_.empty(); }
  /// None within `reach_m`: null.
  [[nodiscard]] const SurfacePoint* nearest(const Eigen::Vector2f& p_map, float reach_m) const;
  /// visit(point) for every point within `radius_m`.
  template <class Visit>
  void for_each_within(const Eigen::Vector2f& p_map, float radius_m, const Visit& visit) const;

 private:
  static constexpr double kBucket_m = 0.25;

  void sort_into_buckets(const PointSet& points);
  void find_normals(const SurfaceMapOptions& options);
  [[nodiscard]] CellBox buckets_within(const Eigen::Vector2f& p, float radius_m) const;
  [[nodiscard]] std::size_t index_of(const Cell& c) const {
    return static_cast<std::size_t>((c.y - box_.min.y) * box_.width() + c.x - box_.min.x);
  }
  [[nodiscard]] std::span<const SurfacePoint> bucket(const Cell& c) const {
    const std::size_t i = index_of(c);
    return {points_.data() + first_[i], first_[i + 1] - first_[i]};
  }

  CellBox box_{{0, 0}, {-1, -1}};     // of buckets
  std::vector<std::uint32_t> first_;  // of each bucket's points, row-major, and the end
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
