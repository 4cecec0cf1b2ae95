#pragma once

#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/map/likelihood_field.hpp>
#include <wayfare/map/occupancy_field.hpp>
#include <wayfare/map/occupancy_grid.hpp>
#include <wayfare/sensors/point_set.hpp>

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
  /// The most detections that may lie around a cell, after the blur; more count as so many. 0: as
  /// many as there are. Maps are told from each other only where it is the same for all.
  double most = 0.0;
};

/// ln of how many detections lie around every cell, over the most that lie around one. For a sensor
/// that detects the same things again and again, and between them anything, the density tells
/// places apart where the probability that a cell is occupied has long come to 1 in all of them.
[[nodiscard]] Result<LikelihoodField> detection_grid(const OccupancyGrid& grid,
                                                     const DetectionViewOptions& options = {});

/// The same where the points of one scan can come to lie, a view fresh for every scan and particle.
/// Farther than the reach from the points' expected places it holds no promise.
class DetectionFieldMaker {
 public:
  /// Makes `view` in its own memory. Errors: no points, a pose or points that are not finite or too
  /// far apart, options out of range (`most` must be given); then `view` is left empty.
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
