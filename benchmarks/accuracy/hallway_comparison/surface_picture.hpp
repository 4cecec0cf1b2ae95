#pragma once

#include <wayfare/io/map_image.hpp>
#include <wayfare/match/correlative.hpp>

namespace wayfare::examples {

/// A score surface at its middle heading, with the robot's heading up: bright near the best score,
/// dark from `depth` of the range below it; `zoom` pixels per cell. The mark is the middle of the
/// window.
[[nodiscard]] io::Image surface_picture(const ScoreSurface& surface, double depth = 1.0,
                                        int zoom = 10);

/// Standard deviations, along and across the robot's heading, of the positions whose score is
/// within a tenth of the range from the best, m.
struct RidgeWidth {
  double along_m = 0.0, across_m = 0.0;
};
[[nodiscard]] RidgeWidth ridge_width(const ScoreSurface& surface);

}  // namespace wayfare::examples
