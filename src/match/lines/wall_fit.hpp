#pragma once

// Total least squares on the points near one or two parallel lines.

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include <wayfare/match/lines.hpp>

#include "match/lines/beams.hpp"

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
  /// Scatter along the lines about their middles, m²: how well each holds the direction.
  std::array<double, 2> spread_m2{};
  std::array<double, 2> slope_rad{}, slope_sigma_rad{};  ///< of each line for itself
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of (direction, left, right)
};

/// Which points belong to a line: those within `at_foot_m` of it, and farther along within
/// `per_m` more for every metre.
struct Window {
  double at_foot_m = 0.0;
  double per_m = 0.0;
  /// Along each line; what stands at its ends, such as the next wall, is left out.
  std::array<double, 2> from_m{-1e300, -1e300}, to_m{1e300, 1e300};
};

/// One step: the points within the window of the guess, one direction for both lines and an offset
/// for each. A line with fewer than `least_beams` is no longer present.
[[nodiscard]] Fit fit_once(const Beams& beams, const Guess& guess, const Window& window,
                           const WallOptions& options);

/// A point near a guessed line, for many looks at it: places to first order in a turn of the line.
struct NearPoint {
  float along_m, across_m;
  std::int16_t length;  ///< of wall it stands for, in units of its own
  std::int16_t side;
};

/// Moves a guess to where most length of wall near the laser lies: of two surfaces, a wall and the
/// doors set back in it, the longer, and neither of the lines that lean from one to the other.
class Settler {
 public:
  /// Each line moved by `reach_m` at most, the direction by `turn_rad`.
  [[nodiscard]] Guess settle(const Beams& beams, const Guess& guess, double reach_m,
                             double turn_rad);

 private:
  void gather(const Beams& beams, const Guess& guess, double reach_m);
  std::vector<NearPoint> points_;
};

/// Steps in windows that shrink to what the noise asks for.
[[nodiscard]] Fit fit_walls(const Beams& beams, const Guess& guess, const WallOptions& options);

}  // namespace wayfare::lines
