#include "surface_picture.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "support/heat_map.hpp"

namespace wayfare::examples {
namespace {

struct Scores {
  const ScoreSurface& surface;
  double best, worst;

  explicit Scores(const ScoreSurface& s) : surface(s) {
    const auto [low, high] = std::minmax_element(s.log_score.begin(), s.log_score.end());
    worst = *low;
    best = *high;
  }
  // 1 for the best, 0 for the worst.
  [[nodiscard]] double relative(int x, int y) const {
    const double range = std::max(best - worst, 1e-12);
    return (surface.at({{x, y}, 0}) - worst) / range;
  }
};

}  // namespace

io::Image surface_picture(const ScoreSurface& surface, double depth, int zoom) {
  const Scores scores(surface);
  const int half = std::min(surface.half_x, surface.half_y);
  const int side = (2 * half + 1) * zoom;
  io::Image image{static_cast<std::size_t>(side), static_cast<std::size_t>(side), 3, {}};
  const Eigen::Matrix2d R = surface.prior.rotation().matrix();
  for (int row = 0; row < side; ++row) {
    for (int column = 0; column < side; ++column) {
      // Up is ahead of the robot, right is to its right.
      const double ahead = half - (row + 0.5) / zoom + 0.5,
                   left = half - (column + 0.5) / zoom + 0.5;
      const Eigen::Vector2d cell = R * Eigen::Vector2d(ahead, left);
      const int x =
          std::clamp(static_cast<int>(std::lround(cell.x())), -surface.half_x, surface.half_x);
      const int y =
          std::clamp(static_cast<int>(std::lround(cell.y())), -surface.half_y, surface.half_y);
      const bool mark = std::abs(std::hypot(ahead, left) - 0.8) < 0.12;
      const auto rgb = mark ? std::array<std::uint8_t, 3>{255, 255, 255}
                            : heat_colour(1.0 - (1.0 - scores.relative(x, y)) / depth);
      image.pixels.insert(image.pixels.end(), rgb.begin(), rgb.end());
    }
  }
  return image;
}

RidgeWidth ridge_width(const ScoreSurface& surface) {
  const Scores scores(surface);
  const Eigen::Matrix2d R = surface.prior.rotation().matrix().transpose();
  Eigen::Vector2d squares = Eigen::Vector2d::Zero();
  double count = 0.0;
  for (int y = -surface.half_y; y <= surface.half_y; ++y) {
    for (int x = -surface.half_x; x <= surface.half_x; ++x) {
      if (scores.relative(x, y) < 0.9) continue;
      const Eigen::Vector2d p = surface.resolution_m * (R * Eigen::Vector2d(x, y));
      squares += p.cwiseAbs2();
      count += 1.0;
    }
  }
  squares = (squares / std::max(count, 1.0)).cwiseSqrt();
  return {squares.x(), squares.y()};
}

}  // namespace wayfare::examples
