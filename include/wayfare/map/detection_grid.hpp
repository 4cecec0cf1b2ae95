#pragma once

#include <wayfare/core/result.hpp>
#include <wayfare/map/match_grid.hpp>
#include <wayfare/map/occupancy_grid.hpp>

namespace wayfare {

/// For the map of a sensor that detects and frees nothing: every detection adds the log-odds of a
/// probability to its cell. Wide enough for 370 of probability 0.52, or 35 of 0.7; a map that is
/// clamped as those of walls are has forgotten after five which of two cells was seen more often.
[[nodiscard]] inline OccupancyGridOptions detection_map(double resolution_m = 0.03) {
  return {resolution_m, 1e-13, 1.0 - 1e-13};
}

struct DetectionViewOptions {
  double hit_probability = 0.52;  ///< as the map was made with
  /// Standard deviation of a detection about the thing detected, m.
  double blur_sigma_m = 0.03;
  /// Detections taken for granted in every cell: what is new or a ghost then decides nothing.
  double background = 0.02;
};

/// ln of how many detections lie around every cell, over the most that lie around one. For a sensor
/// that detects the same things again and again, and between them anything, the density tells
/// places apart where the probability that a cell is occupied has long come to 1 in all of them.
[[nodiscard]] Result<MatchGrid> detection_grid(const OccupancyGrid& grid,
                                               const DetectionViewOptions& options = {});

}  // namespace wayfare
