#pragma once

#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/map/likelihood_field.hpp>
#include <wayfare/map/occupancy_field.hpp>
#include <wayfare/map/occupancy_grid.hpp>
#include <wayfare/sensors/point_set.hpp>

namespace wayfare {

/// For the map of a sensor that gives detections but no free space: every detection adds the
/// log-odds of a probability to its cell. The clamping leaves room for 370 detections of
/// probability 0.52, or 35 of 0.7; the clamping of occupancy maps saturates after five.
[[nodiscard]] inline OccupancyGridOptions detection_map(double resolution_m = 0.03) {
  return {resolution_m, 1e-13, 1.0 - 1e-13};
}

struct DetectionViewOptions {
  double hit_probability = 0.52;  ///< the one the map was built with
  /// Standard deviation of a detection about the object detected, m.
  double blur_sigma_m = 0.03;
  /// Number of detections assumed in every cell, so that new objects and ghosts have little effect.
  double background = 0.02;
  /// Upper bound of the density after the blur, detections. 0: the map's maximum. The scores of
  /// different maps are comparable only if it is the same for all.
  double max_detections = 0.0;
};

/// ln of the density of detections at every cell relative to the maximum. For a sensor with
/// repeated detections of the same objects and clutter between them, the density is informative
/// where the occupancy probabilities have all saturated at 1.
[[nodiscard]] Result<LikelihoodField> detection_grid(const OccupancyGrid& grid,
                                                     const DetectionViewOptions& options = {});

/// The same, only for the cells that the points of one scan can reach, built for every scan and
/// particle. Its values farther than `reach` from the points' expected positions are undefined.
class DetectionFieldMaker {
 public:
  /// Rebuilds `view`, reusing its memory. Errors, with `view` left empty: no points, a pose or
  /// points that are not finite or too far apart, options out of range (`max_detections` must be
  /// positive).
  Result<void> make(const OccupancyGrid& grid, const PointSet& points, const SE2d& T_map_points,
                    const FieldReach& reach, const DetectionViewOptions& options,
                    LikelihoodField& view);

 private:
  void prepare_kernel(double sigma_cells);
  void spread(const OccupancyGrid& grid, const CellBox& box, double hit_nats);
  void write(const DetectionViewOptions& options, LikelihoodField& view) const;

  int radius_ = -1;
  double sigma_cells_ = -1.0;
  std::vector<float> kernel_;   // rows of 2 radius + 1
  std::vector<float> density_;  // row-major, the view's cells
};

}  // namespace wayfare
