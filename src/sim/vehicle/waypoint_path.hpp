#pragma once

// The path of a vehicle through waypoints: straight pieces and corners, with continuous curvature.

#include <span>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/result.hpp>
#include <wayfare/sim/vehicle_trajectory.hpp>

namespace wayfare::sim {

/// A straight piece (turn 0) or a corner.
struct PathPiece {
  double begin_m = 0.0;  ///< along the path
  double length_m = 0.0;
  Eigen::Vector2d from = Eigen::Vector2d::Zero();
  double heading = 0.0;  ///< at its beginning, not wrapped
  double turn = 0.0;
};

/// A point on the path; curvature is positive to the right, as headings are.
struct PathPoint {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  double heading = 0.0;
  double curvature = 0.0;
};

struct HeightMark {
  double along_m = 0.0, height_m = 0.0;
};
struct PathStop {
  double along_m = 0.0, duration_s = 0.0;
};

class WaypointPath {
 public:
  [[nodiscard]] double length_m() const { return pieces_.back().begin_m + pieces_.back().length_m; }
  [[nodiscard]] const std::vector<PathPiece>& pieces() const { return pieces_; }
  [[nodiscard]] const std::vector<PathStop>& stops() const { return stops_; }

  void add(double length_m, const Eigen::Vector2d& from, double heading, double turn) {
    const double begin = pieces_.empty() ? 0.0 : length_m_so_far_;
    pieces_.push_back({begin, length_m, from, heading, turn});
    length_m_so_far_ = begin + length_m;
  }
  void mark(double height_m, double along_m) { heights_.push_back({along_m, height_m}); }
  void stop(double duration_s) { stops_.push_back({length_m_so_far_, duration_s}); }
  [[nodiscard]] double length_so_far() const { return length_m_so_far_; }

  [[nodiscard]] PathPoint at(double along_m) const;
  /// Horizontal at every waypoint, cubic between.
  [[nodiscard]] double height_at(double along_m) const;

 private:
  [[nodiscard]] const PathPiece& piece_at(double along_m) const;

  std::vector<PathPiece> pieces_;
  std::vector<HeightMark> heights_;
  std::vector<PathStop> stops_;
  double length_m_so_far_ = 0.0;
};

/// Rounds the corners as widely as the limits require and the adjacent legs permit. Errors: fewer
/// than two waypoints, one that is not finite or at the position of the previous one, a path that
/// reverses.
[[nodiscard]] Result<WaypointPath> path_through(std::span<const Waypoint> waypoints,
                                                const VehicleLimits& limits);

}  // namespace wayfare::sim
