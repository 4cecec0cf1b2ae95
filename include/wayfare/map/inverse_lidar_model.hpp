#pragma once

// Occupancy probabilities given a beam of a LiDAR.

#include <wayfare/core/angle.hpp>

namespace wayfare {

/// Occupancy probabilities given one beam, for insert_scan and insert_points.
struct InverseLidarModel {
  /// Occupancy probability of a cell a beam passed through. Lower values clear moved objects
  /// sooner, but grazing beams erode walls.
  double p_free = 0.2;
  /// Occupancy probability of the cell a beam ended in.
  double p_hit = 0.9;
  /// Returns farther than this, m, are not hits: the beam only frees cells up to this range.
  double max_usable_range_m = 60.0;
  /// Range a beam without return frees, m; zero for sensors that also give no return on glass or
  /// black paint.
  double free_range_without_return_m = 0.0;
  /// Largest angle between neighbouring beams, for FillBetweenBeams only. Avoid whole multiples of
  /// the scan's angular step, where rounding decides.
  Angle fill_gap = Angle::degrees(2.1);
};

}  // namespace wayfare
