#pragma once

// Line segments of a scan by split and merge (Nguyen et al. 2005, section II), and candidates for a
// corridor's walls, before the fit.

#include <optional>
#include <span>
#include <vector>

#include "match/lines/wall_fit.hpp"

namespace wayfare::lines {

struct Segment {
  double x_m = 0.0, y_m = 0.0;  ///< midpoint
  double ux = 1.0, uy = 0.0;    ///< direction
  double length_m = 0.0;
  double weight_m = 0.0;  ///< length, reduced if it deviates from a line by more than the noise
};

/// Line through the mean of the points from `begin` to before `end`, along the direction of
/// greatest scatter: no singular direction.
[[nodiscard]] Segment fit(const Beams& beams, std::size_t begin, std::size_t end, double noise_m);

/// The segments of `beams`, in the order of the scan.
[[nodiscard]] std::vector<Segment> split(const Beams& beams, const WallOptions& options);

struct Candidate {
  Guess lines;
  double support_m = 0.0;  ///< total length of the segments that agree
};

/// Directions and offsets with the greatest total length of `segments`, in decreasing order; at
/// most three directions.
[[nodiscard]] std::vector<Candidate> agreed_walls(std::span<const Segment> segments,
                                                  std::optional<Angle> near,
                                                  const WallOptions& options);

/// The direction and offsets whose replicas agree with most beams, by exhaustive search over
/// heading and lateral distance (Liu 2015, section 5).
[[nodiscard]] std::vector<Candidate> correlated_walls(const Beams& beams, std::optional<Angle> near,
                                                      const WallOptions& options);

/// Lines fitted to moving windows of points, see WallDetector::fit_windows().
[[nodiscard]] std::optional<CorridorWalls> windowed_walls(const Beams& beams,
                                                          std::optional<Angle> near,
                                                          const WallOptions& options);

/// The direction that most length is along or across, see WallDetector::square_direction().
[[nodiscard]] std::optional<SquareDirection> square_direction(std::span<const Segment> segments,
                                                              Angle near, Angle within,
                                                              double min_support_m);

/// The longest segment across the corridor ahead, as a direction and an offset to its left.
[[nodiscard]] std::optional<Guess> wall_across(std::span<const Segment> segments,
                                               double direction_rad);

}  // namespace wayfare::lines
