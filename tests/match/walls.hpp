#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <wayfare/core/random.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/sensors/scans.hpp>

namespace wayfare {

/// Straight walls, and their scan by a range finder with 360° field of view.
struct Walls {
  struct Wall {
    Eigen::Vector2d from, to;
  };
  std::vector<Wall> walls;

  void box(const Eigen::Vector2d& low, const Eigen::Vector2d& high) {
    const Eigen::Vector2d a(high.x(), low.y()), b(low.x(), high.y());
    walls.insert(walls.end(), {{low, a}, {a, high}, {high, b}, {b, low}});
  }

  /// A room of 10 m × 7 m about the origin with a cupboard, a side of a table and a pillar.
  [[nodiscard]] static Walls room() {
    Walls w;
    w.box({-5, -3.5}, {5, 3.5});
    w.box({2.5, 2.3}, {4.2, 3.5});
    w.box({-4.6, -2.0}, {-4.0, -0.4});
    w.box({0.8, -2.9}, {1.2, -2.5});
    return w;
  }
  /// Two walls 2.4 m apart, along a line at this angle, longer than any range.
  [[nodiscard]] static Walls corridor(Angle heading) {
    const SO2d rotation(heading);
    Walls w;
    for (const double y : {-1.2, 1.2})
      w.walls.push_back({rotation * Eigen::Vector2d(-60, y), rotation * Eigen::Vector2d(60, y)});
    return w;
  }
  [[nodiscard]] static Walls round_room(double radius_m) {
    Walls w;
    constexpr int kSides = 360;
    const auto corner = [&](int i) {
      const double a = 2 * std::numbers::pi * i / kSides;
      return Eigen::Vector2d(radius_m * std::cos(a), radius_m * std::sin(a));
    };
    for (int i = 0; i < kSides; ++i) w.walls.push_back({corner(i), corner(i + 1)});
    return w;
  }

  /// 360 beams of up to 12 m.
  [[nodiscard]] LaserScan scan(const SE2d& pose, Rng& rng, double noise_m = 0.01) const {
    LaserScan s;
    s.first_bearing = Angle::degrees(-180);
    s.bearing_step = Angle::degrees(1);
    s.max_range_m = 12;
    for (std::size_t i = 0; i < 360; ++i) {
      const Eigen::Vector2d direction = SO2d(pose.heading() + s.bearing(i)) * Eigen::Vector2d(1, 0);
      const double range = distance(pose.translation(), direction);
      s.ranges_m.push_back(static_cast<float>(range + rng.normal(0, noise_m)));
    }
    return s;
  }

  [[nodiscard]] double distance(const Eigen::Vector2d& from,
                                const Eigen::Vector2d& direction) const {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Wall& w : walls) {
      const Eigen::Vector2d along = w.to - w.from, gap = w.from - from;
      const double cross = direction.x() * along.y() - direction.y() * along.x();
      const double range = (gap.x() * along.y() - gap.y() * along.x()) / cross;
      const double part = (gap.x() * direction.y() - gap.y() * direction.x()) / cross;
      if (range > 0 && part >= 0 && part <= 1) nearest = std::min(nearest, range);
    }
    return nearest;
  }
};

}  // namespace wayfare
