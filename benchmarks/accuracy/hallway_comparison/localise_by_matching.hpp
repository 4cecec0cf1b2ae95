#pragma once

// Localisation by scan matching alone (Zhang 2020, section 5.2): each scan is matched to the map of
// all earlier ones; odometry gives only the start of the search.

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/map/occupancy_grid.hpp>
#include <wayfare/match/correlative.hpp>
#include <wayfare/sensors/recording.hpp>
#include <wayfare/sync/augmented_scans.hpp>

namespace wayfare::examples {

enum class Sensor { odometry, lidar, radar };

struct MatchingOptions {
  SearchWindow window{0.3, 0.3, Angle::degrees(10)};
  double resolution_m = 0.03;
  /// Standard deviations of the blur of each map before matching: a radar's bearings are wide.
  double lidar_blur_m = 0.05;
  double radar_blur_m = 0.03;
  double match_every_m = 0.15;  ///< a scan is matched once the robot has moved this far …
  Angle match_every = Angle::degrees(10);  ///< … or turned this much
  double min_score = 0.05;                 ///< matches below it are refused: odometry is kept
  std::size_t fewest_points = 60;          ///< scans with fewer points are refused
  /// Of one detection: small, so that cells with hundreds of detections still differ.
  double radar_hit_probability = 0.52;
  LogTime surface_at;  ///< the scores of the first scan after this time are kept
};

struct MatchingRun {
  Trajectory trajectory;
  std::size_t matched = 0, refused = 0;
  OccupancyGrid map{OccupancyGridOptions{}};
  /// The scores around the best pose at `surface_at`, over the window, at the best heading.
  std::optional<ScoreSurface> surface;
};

/// `start` is the true pose at the first step.
[[nodiscard]] Result<MatchingRun> localise_by_matching(std::span<const SyncedStep> steps,
                                                       const Recording& recording, Sensor sensor,
                                                       const SE2d& start,
                                                       const MatchingOptions& options);

}  // namespace wayfare::examples
