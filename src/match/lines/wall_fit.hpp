#pragma once

// Total least squares on the points near one or two parallel lines.

#include <array>

#include <Eigen/Core>

#include <wayfare/match/lines.hpp>

namespace wayfare::lines {

/// Two parallel lines, one to the left of the direction (0) and one to the right (1).
struct Guess {
  double direction_rad = 0.0;
  std::array<double, 2> offset_m{};  ///< left > 0, right < 0
  std::array<bool, 2> present{};
};

struct Fit {
  Guess lines;
  std::array<int, 2> beams{}, expected{};
  std::array<double, 2> begin_m{}, end_m{};
  /// Scatter along the lines about their means, m²: how well each determines the direction.
  std::array<double, 2> spread_m2{};
  std::array<double, 2> slope_rad{}, slope_sigma_rad{};  ///< of each line alone
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of (direction, left, right)
};

/// Moves a guess to the offset and direction with the greatest length of wall near the laser: of a
/// wall and the doors recessed in it the longer, rather than an oblique line between them. Changes
/// each offset by `max_shift_m` at most, the direction by `max_turn_rad`.
[[nodiscard]] Guess align(const Beams& beams, const Guess& guess, double max_shift_m,
                          double max_turn_rad);

/// Iterations in windows that shrink to a multiple of the noise.
[[nodiscard]] Fit fit_walls(const Beams& beams, const Guess& guess, const WallOptions& options);

}  // namespace wayfare::lines
