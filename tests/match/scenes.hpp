#pragma once

#include <cmath>

#include <wayfare/core/random.hpp>
#include <wayfare/map/likelihood_field.hpp>

namespace wayfare {

/// Points on the walls of a rectangle about the origin.
inline PointSet rectangle(double half_x, double half_y, int n, Rng& rng, double noise = 0.01) {
  PointSet points;
  for (int i = 0; i < n; ++i) {
    const double t = rng.uniform(-1, 1), sign = rng.uniform() < 0.5 ? -1 : 1;
    const bool side = rng.uniform() < half_y / (half_x + half_y);
    const double x = side ? sign * half_x : t * half_x, y = side ? t * half_y : sign * half_y;
    points.push_back(
        Eigen::Vector2d(x + rng.normal(0, noise), y + rng.normal(0, noise)).cast<float>());
  }
  return points;
}

inline PointSet moved(const PointSet& points, const SE2d& T) {
  PointSet out;
  for (std::size_t i = 0; i < points.size(); ++i)
    out.push_back((T * Eigen::Vector2d(points[i].cast<double>())).cast<float>());
  return out;
}

/// A table of random values, sparse enough to have peaks.
inline LikelihoodField random_grid(Rng& rng, int width, int height, Cell origin) {
  LikelihoodField grid;
  (void)grid.reset(0.05, {origin, origin + Cell{width - 1, height - 1}}, 0.01);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      if (rng.uniform() < 0.2)
        grid.data()[y * grid.stride() + x] =
            static_cast<std::uint16_t>(rng.below(LikelihoodField::kMaxValue + 1));
  return grid;
}

}  // namespace wayfare
