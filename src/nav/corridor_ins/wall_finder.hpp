#pragma once

// Side walls and walls across in a scan, tracked or acquired.

#include <cmath>
#include <optional>

#include <wayfare/nav/corridor_ins.hpp>

#include "nav/corridor_ins/wall_states.hpp"

namespace wayfare::corridor {

[[nodiscard]] inline WallOptions detector_options(const CorridorInsOptions& o) {
  WallOptions walls = o.walls;
  walls.end_walls = o.use_end_walls;
  return walls;
}

class WallFinder {
 public:
  explicit WallFinder(const CorridorInsOptions& options)
      : options_(options), detector_(detector_options(options)) {}

  [[nodiscard]] WallDetector& detector() { return detector_; }

  /// Tracks the walls; acquires new ones if there are none, `can_track` is false or tracking fails.
  void find(const LaserScan& scan, const Predicted& predicted, bool has_walls, bool can_track,
            CorridorReport& report, CorridorScanUpdate& update) {
    const bool known = has_walls && can_track;
    if (options_.search == WallSearch::windows) {
      const auto near = known ? std::optional(predicted.walls.direction) : std::nullopt;
      update.walls = detector_.fit_windows(scan, near);
    } else if (known) {
      update.walls = detector_.track(scan, predicted.walls);
      update.tracked = update.walls.has_value();
    }
    if (update.tracked) {
      ++report.tracked;
      search_missing_walls(scan, predicted, report, update);
    } else {
      if (options_.search == WallSearch::tracking) update.walls = detector_.acquire(scan);
      report.acquisitions += update.walls ? 1 : 0;
      if (update.walls && has_walls)
        update.walls = facing(*update.walls, predicted.walls.direction);
    }
    if (update.walls) add_noise(*update.walls);
    report.scans_with_walls += update.walls ? 1 : 0;
    report.not_parallel += update.walls && !update.walls->parallel ? 1 : 0;
  }

 private:
  void add_noise(CorridorWalls& walls) const {
    const double turn2 = options_.wall_direction_sigma_rad * options_.wall_direction_sigma_rad;
    const double offset2 = options_.wall_offset_sigma_m * options_.wall_offset_sigma_m;
    walls.covariance.diagonal() += Eigen::Vector3d(turn2, offset2, offset2);
    if (walls.end) walls.end->covariance.diagonal() += Eigen::Vector2d(offset2, turn2);
  }

  /// Periodic search for the other side wall, or one across the corridor.
  void search_missing_walls(const LaserScan& scan, const Predicted& predicted,
                            const CorridorReport& report, CorridorScanUpdate& update) {
    constexpr int kEvery = 5;
    const bool one_side = !predicted.walls.left || !predicted.walls.right;
    const bool no_end = options_.use_end_walls && !predicted.walls.end;
    if ((!one_side && !no_end) || report.scans % kEvery != 0) return;
    const auto found = detector_.acquire(scan, predicted.walls.direction);
    if (!found) return;
    if (no_end && found->end) update.walls->end = found->end;
    if (!predicted.walls.left) {
      update.walls->left = found->left;
      update.walls->covariance(1, 1) = found->covariance(1, 1);
    }
    if (!predicted.walls.right) {
      update.walls->right = found->right;
      update.walls->covariance(2, 2) = found->covariance(2, 2);
    }
  }

  CorridorInsOptions options_;
  WallDetector detector_;
};

}  // namespace wayfare::corridor
