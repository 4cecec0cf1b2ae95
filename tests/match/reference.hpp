#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include <wayfare/match/correlative.hpp>

namespace wayfare {

struct Reference {
  double objective = 0;
  std::int64_t sum = 0;
  Candidate candidate;
  bool found = false;
};

/// The definition, without optimisation: each point's cell in single precision plus the candidate's
/// offset, LikelihoodField::value summed.
inline Reference brute_force(const LikelihoodField& grid, const PointSet& points, const SE2d& prior,
                             const ScoreSurface& shape, const MatchOptions& options) {
  const double scale = 1.0 / grid.resolution_m(), n = static_cast<double>(points.size());
  const double independent = options.independent_points > 0 ? options.independent_points : n;
  const double weight = grid.log_step() * std::min(1.0, independent / n);
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() = prior.rotation().matrix();
  const Eigen::Matrix3d information =
      turn * options.prior_information.value_or(Eigen::Matrix3d::Zero()) * turn.transpose();
  const auto cell = [](float t) {
    return static_cast<int>(std::floor(std::clamp(t, -1048576.0F, 1048576.0F)));
  };
  Reference best;
  std::array<int, 4> best_key{};
  for (int k = -shape.half_heading; k <= shape.half_heading; ++k) {
    const double heading = prior.heading().radians() + k * shape.heading_step.radians();
    const auto c = static_cast<float>(std::cos(heading) * scale);
    const auto s = static_cast<float>(std::sin(heading) * scale);
    const auto ox = static_cast<float>(prior.x() * scale - grid.origin().x);
    const auto oy = static_cast<float>(prior.y() * scale - grid.origin().y);
    for (int y = -shape.half_y; y <= shape.half_y; ++y)
      for (int x = -shape.half_x; x <= shape.half_x; ++x) {
        std::int64_t sum = 0;
        for (std::size_t i = 0; i < points.size(); ++i) {
          const float px = points.x_m()[i], py = points.y_m()[i];
          const Cell at{cell(c * px - s * py + ox), cell(s * px + c * py + oy)};
          sum += grid.value(at + Cell{x, y} + grid.origin());
        }
        if (static_cast<double>(sum) < options.min_score * n * LikelihoodField::kMaxValue) continue;
        const Eigen::Vector3d d(x * grid.resolution_m(), y * grid.resolution_m(),
                                k * shape.heading_step.radians());
        const double objective = weight * static_cast<double>(sum) - 0.5 * d.dot(information * d);
        const std::array<int, 4> key{x * x + y * y + k * k, k, y, x};
        if (best.found &&
            (objective < best.objective || (objective == best.objective && key >= best_key)))
          continue;
        best = {objective, sum, {{x, y}, k}, true};
        best_key = key;
      }
  }
  return best;
}

}  // namespace wayfare
