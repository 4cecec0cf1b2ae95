#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/random.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/map/likelihood_field.hpp>
#include <wayfare/sensors/point_set.hpp>

namespace wayfare::testing {

/// A room of five unequal walls, about 9 m × 6 m, convex: all walls are seen from everywhere.
class LawRoom {
 public:
  static constexpr double kNoise_m = 0.01;

  /// A pose at least 1 m from the walls, of any heading.
  [[nodiscard]] static SE2d place(Rng& rng) {
    return SE2d(rng.uniform(-2.5, 2.5), rng.uniform(-1.5, 1.5), Angle::radians(rng.uniform(-3, 3)));
  }

  /// 400 points of the walls in the axes of `pose`.
  [[nodiscard]] static PointSet seen_from(const SE2d& pose, Rng& rng) {
    PointSet points;
    for (std::size_t wall = 0; wall < kCorners.size(); ++wall) {
      const auto& a = kCorners[wall];
      const auto& b = kCorners[(wall + 1) % kCorners.size()];
      for (int i = 0; i < 80; ++i) {
        const double t = rng.uniform(0, 1);
        const Eigen::Vector2d at(a[0] + t * (b[0] - a[0]) + rng.normal(0, kNoise_m),
                                 a[1] + t * (b[1] - a[1]) + rng.normal(0, kNoise_m));
        points.push_back((pose.inverse() * at).cast<float>());
      }
    }
    return points;
  }

  /// Scans from several places. Not copied: `placed` refers to the points.
  struct Views {
    std::vector<PointSet> points;
    std::vector<PlacedPoints> placed;

    Views(int count, Rng& rng) {
      std::vector<SE2d> poses;
      for (int i = 0; i < count; ++i) {
        poses.push_back(place(rng));
        points.push_back(seen_from(poses.back(), rng));
      }
      for (std::size_t i = 0; i < points.size(); ++i) placed.push_back({&points[i], poses[i]});
    }
    Views(const Views&) = delete;
    Views& operator=(const Views&) = delete;
  };

 private:
  static constexpr std::array<std::array<double, 2>, 5> kCorners{
      {{-4.0, -3.0}, {4.0, -2.6}, {4.8, 1.0}, {2.0, 3.2}, {-4.4, 2.6}}};
};

}  // namespace wayfare::testing
