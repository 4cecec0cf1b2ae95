#pragma once

#include <wayfare/io/image.hpp>
#include <wayfare/match/correlative.hpp>

namespace wayfare::examples {

/// A score surface (its middle heading) from above, the robot's way pointing up: bright where the
/// score is near its best, dark from `depth` of its range below; `zoom` pixels a cell. The mark is
/// the middle of the window.
[[nodiscard]] io::Image surface_picture(const ScoreSurface& surface, double depth = 1.0,
                                        int zoom = 10);

/// Extent, in metres, of the places whose score is within a tenth of its range from the best: the
/// standard deviations along and across the robot's way, about the best.
struct RidgeWidth {
  double along_m = 0.0, across_m = 0.0;
};
[[nodiscard]] RidgeWidth ridge_width(const ScoreSurface& surface);

}  // namespace wayfare::examples
