#pragma once

// Line segments of a scan by split and merge (Nguyen et al. 2005, section II).

#include <vector>

#include <wayfare/match/lines.hpp>

namespace wayfare::lines {

struct Segment {
  double x_m = 0.0, y_m = 0.0;  ///< midpoint
  double ux = 1.0, uy = 0.0;    ///< direction
  double length_m = 0.0;
  double weight_m = 0.0;  ///< length, reduced if it deviates from a line by more than the noise
};

/// The segments of `beams`, in the order of the scan.
[[nodiscard]] std::vector<Segment> split(const Beams& beams, const WallOptions& options);

}  // namespace wayfare::lines
