#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include <wayfare/sensors/point_set.hpp>

namespace wayfare {

/// Points in a quarter of a PointSet's memory, at a resolution of 2 mm.
class PackedPoints {
 public:
  static constexpr float kUnit_m = 0.002F;  // ±65 m
  static constexpr double kMaxRange_m = 60.0;

  PackedPoints() = default;
  /// All points lie within kMaxRange_m along each axis.
  explicit PackedPoints(const PointSet& points) {
    xy_.reserve(2 * points.size());
    for (std::size_t i = 0; i < points.size(); ++i)
      for (const float t : {points[i].x(), points[i].y()})
        xy_.push_back(static_cast<std::int16_t>(std::lround(t / kUnit_m)));
  }
  explicit PackedPoints(std::vector<std::int16_t> xy) : xy_(std::move(xy)) {}

  [[nodiscard]] PointSet unpacked() const {
    PointSet points;
    points.reserve(xy_.size() / 2);
    for (std::size_t i = 0; i + 1 < xy_.size(); i += 2)
      points.push_back(
          {kUnit_m * static_cast<float>(xy_[i]), kUnit_m * static_cast<float>(xy_[i + 1])});
    return points;
  }
  [[nodiscard]] const std::vector<std::int16_t>& xy() const { return xy_; }

 private:
  std::vector<std::int16_t> xy_;
};

}  // namespace wayfare
