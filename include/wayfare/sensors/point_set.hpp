#pragma once

// The points of a scan in the layout of the match and map kernels: structure of arrays, single
// precision, padded to whole vectors.

#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/detail/reset_on_move.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/sensors/scans.hpp>

namespace wayfare {

/// Points of the plane, metres. The arrays are padded to a multiple of 16 with copies of the last
/// point; `size()` does not count the padding. Empty once it was moved from.
class PointSet {
 public:
  static constexpr std::size_t kLanes = 16;  ///< floats of the widest vector

  PointSet() = default;

  /// Number of points, without the padding.
  [[nodiscard]] std::size_t size() const { return size_; }
  /// Whether it has no points.
  [[nodiscard]] bool empty() const { return size_ == 0; }
  /// The first coordinates, size() of them.
  [[nodiscard]] std::span<const float> x_m() const { return {x_.data(), size_}; }
  /// The second coordinates, size() of them.
  [[nodiscard]] std::span<const float> y_m() const { return {y_.data(), size_}; }
  /// Including the padding; a multiple of kLanes long.
  [[nodiscard]] std::span<const float> padded_x_m() const { return x_; }
  /// Including the padding; a multiple of kLanes long.
  [[nodiscard]] std::span<const float> padded_y_m() const { return y_; }
  /// Point i < size().
  [[nodiscard]] Eigen::Vector2f operator[](std::size_t i) const { return {x_[i], y_[i]}; }

  /// Memory for `n` points.
  void reserve(std::size_t n) {
    x_.reserve(n + kLanes);
    y_.reserve(n + kLanes);
  }
  /// Appends a point and renews the padding.
  void push_back(const Eigen::Vector2f& p) {
    x_.resize(size_);
    y_.resize(size_);
    size_ = size_ + 1;
    const std::size_t padded = (size_ + kLanes - 1) / kLanes * kLanes;
    x_.resize(padded, p.x());
    y_.resize(padded, p.y());
  }

  /// Distance of the farthest point from the origin.
  [[nodiscard]] float max_norm_m() const {
    float square = 0.0F;
    for (std::size_t i = 0; i < size_; ++i) {
      const float d = x_[i] * x_[i] + y_[i] * y_[i];
      square = d > square ? d : square;
    }
    return std::sqrt(square);
  }

 private:
  ResetOnMove<std::size_t> size_;
  std::vector<float> x_, y_;
};

/// The end points of the beams that returned, in the target frame of `T_frame_laser`.
[[nodiscard]] inline PointSet end_points(const LaserScan& scan, const SE2d& T_frame_laser = {}) {
  PointSet points;
  points.reserve(scan.ranges_m.size());
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    if (!scan.returned(i)) continue;
    const double bearing = scan.bearing(i).radians();
    const auto range = static_cast<double>(scan.ranges_m[i]);
    const Eigen::Vector2d p =
        T_frame_laser * Eigen::Vector2d(range * std::cos(bearing), range * std::sin(bearing));
    points.push_back(p.cast<float>());
  }
  return points;
}

/// Of the points within `max_norm_m` of the origin, those about `spacing_m` apart along the scan:
/// near walls, which a scan samples densely, then weigh no more than far ones. The spacing may fall
/// short by the errors of the points.
///
/// A point is chosen by the points before it, not by its own distance from the last one kept: those
/// whose error leads them away from it would be preferred, and a wall appear turned.
[[nodiscard]] inline PointSet thin(const PointSet& points, float spacing_m, float max_norm_m) {
  constexpr float kJump = 3.0F;  // spacings, to another wall
  PointSet kept;
  kept.reserve(points.size());
  Eigen::Vector2f last = Eigen::Vector2f::Zero();
  float step_m = 0.0F;  // between points up to `last`
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector2f p = points[i];
    if (!(p.norm() <= max_norm_m)) continue;
    const float to_p_m = (p - last).norm();
    const bool jump = kept.empty() || to_p_m > kJump * spacing_m;
    if (jump || (last - kept[kept.size() - 1]).norm() + step_m >= spacing_m) kept.push_back(p);
    if (!jump) step_m = to_p_m;
    last = p;
  }
  return kept;
}

}  // namespace wayfare
