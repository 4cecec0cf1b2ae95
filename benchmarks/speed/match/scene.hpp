#pragma once

// The scene of the benchmarks: 20 scans of 356 points of a 12 m × 9 m room with 40 boxes, and a
// 21st to be matched to them.

#include <algorithm>
#include <utility>
#include <vector>

#include <wayfare/core/random.hpp>
#include <wayfare/map/likelihood_field.hpp>
#include <wayfare/match/scan_matcher.hpp>
#include <wayfare/sensors/scans.hpp>

namespace wayfare {

struct Box {
  Eigen::Vector2d low, high;
};

struct Scene {
  std::vector<LaserScan> scans;
  std::vector<PointSet> points;
  std::vector<SE2d> poses;
  std::vector<PlacedPoints> placed;
  LikelihoodField field;
  PointSet seen;
  SE2d prior;

  Scene() {
    Rng rng(1);
    std::vector<Box> boxes;
    for (int i = 0; i < 40; ++i) {
      const Eigen::Vector2d p(rng.uniform(-5.5, 5.0), rng.uniform(-4.0, 3.8));
      if (p.norm() < 1.8) continue;
      boxes.push_back({p, p + Eigen::Vector2d(rng.uniform(0.1, 0.8), rng.uniform(0.1, 0.8))});
    }
    for (int i = 0; i < 21; ++i) {
      poses.emplace_back(rng.uniform(-1, 1), rng.uniform(-1, 1), Angle::radians(0.3 * i));
      scans.push_back(sweep(poses.back(), boxes, rng));
      points.push_back(end_points(scans.back()));
    }
    for (std::size_t i = 0; i < 20; ++i) placed.push_back({&points[i], poses[i]});
    field = *likelihood_field(placed);
    seen = points[20];
    prior = poses[20].plus({0.17, -0.11, 0.2});
  }

  static LaserScan sweep(const SE2d& pose, const std::vector<Box>& boxes, Rng& rng) {
    LaserScan scan;
    scan.first_bearing = Angle::degrees(-178);
    scan.bearing_step = Angle::degrees(1);
    scan.max_range_m = 30;
    for (int i = 0; i < 356; ++i) {
      const SO2d turn(pose.heading() + scan.first_bearing + scan.bearing_step * i);
      const Eigen::Vector2d d = turn * Eigen::Vector2d(1, 0), p = pose.translation();
      double range = exit({{-6, -4.5}, {6, 4.5}}, p, d).second;
      for (const Box& b : boxes) {
        const auto [in, out] = exit(b, p, d);
        if (in < out && in > 0) range = std::min(range, in);
      }
      scan.ranges_m.push_back(static_cast<float>(range + rng.normal(0, 0.01)));
    }
    return scan;
  }
  /// Where the ray enters and leaves the box.
  static std::pair<double, double> exit(const Box& b, const Eigen::Vector2d& p,
                                        const Eigen::Vector2d& d) {
    const Eigen::Array2d s = (b.low - p).array() / d.array(), t = (b.high - p).array() / d.array();
    return {s.min(t).maxCoeff(), s.max(t).minCoeff()};
  }
};

inline const Scene& scene() {
  static const Scene made;
  return made;
}
inline const SearchWindow kSmall{0.3, 0.3, Angle::degrees(20)};
inline const SearchWindow kLarge{7, 7, Angle::degrees(30)};

}  // namespace wayfare
