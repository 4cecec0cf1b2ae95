#pragma once

// Where a corridor's walls may be, before any fit.

#include <optional>
#include <span>
#include <vector>

#include "match/lines/segments.hpp"
#include "match/lines/wall_fit.hpp"

namespace wayfare::lines {

struct Candidate {
  Guess lines;
  double support_m = 0.0;  ///< length of the pieces that agree
};

/// Directions and offsets that much of the length of `segments` agrees on, the most first: of two
/// directions at most, as a room has them.
[[nodiscard]] std::vector<Candidate> agreed_walls(std::span<const Segment> segments,
                                                  std::optional<Angle> near,
                                                  const WallOptions& options);

/// The one direction and offsets whose replicas most beams agree with, found by trying every
/// heading and lateral distance (Liu 2015, section 5).
[[nodiscard]] std::vector<Candidate> correlated_walls(const Beams& beams, std::optional<Angle> near,
                                                      const WallOptions& options);

/// The longest piece across, in front, as a direction and an offset to its left.
[[nodiscard]] std::optional<Guess> wall_across(std::span<const Segment> segments,
                                               double direction_rad);

}  // namespace wayfare::lines
