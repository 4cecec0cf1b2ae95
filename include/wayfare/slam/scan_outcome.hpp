#pragma once

// Types common to the SLAM systems that process scans.

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>

#include <Eigen/Core>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/detail/eigen_alignment.hpp>
#include <wayfare/core/frame.hpp>
#include <wayfare/core/result.hpp>

namespace wayfare {

/// Errors of a path since a place was last seen, a random walk: standard deviations after one
/// metre, growing with the root of the distance.
struct PathDrift {
  double m_per_sqrt_m = 0.01;                    ///< along either axis
  Angle turn_per_sqrt_m = Angle::degrees(0.15);  ///< of the heading

  /// Of x and y, m², and heading, rad², after a stretch of the path.
  [[nodiscard]] Eigen::Matrix3d covariance(double travel_m) const {
    const double turn = turn_per_sqrt_m.radians();
    return (travel_m * Eigen::Vector3d(m_per_sqrt_m, m_per_sqrt_m, turn).cwiseAbs2()).asDiagonal();
  }
};

/// Errors that a matcher returned, of `make_map` too, and results of it that are not valid: a pose,
/// score, constraint or covariance that is not finite, a covariance that is not positive
/// semi-definite. None of them placed a scan or closed a loop.
struct MatcherErrors {
  std::size_t count = 0;  ///< number of all
  std::string first;      ///< where and why: "loop: the matcher's result is not finite: its pose"

  /// Counts one.
  void add(const Error& error) {
    if (count++ == 0) first = error.message;
  }
  /// Counts `more`; `where` is put in front of the first message.
  void add(const MatcherErrors& more, std::string_view where = {}) {
    if (count == 0 && more.count > 0)
      first = where.empty() ? more.first : std::string(where) + ": " + more.first;
    count += more.count;
  }
};

/// Result of one scan.
struct ScanOutcome {
  Transform2<frame::Map, frame::Base> T_map_base;  ///< pose of the scan by the graph or map so far
  double score = 0.0;    ///< agreement with the local map in [0, 1]; 0 where not matched
  bool matched = false;  ///< false: too few points or poor agreement; the predicted pose is kept
  bool became_node = false;      ///< it was added to the graph or map
  int loop_closures = 0;         ///< found at this scan
  MatcherErrors matcher_errors;  ///< at this scan, or in the search for loops joined at it
};

/// Counts of the pieces of a trajectory: a new one begins where tracking is lost or odometry leaps.
struct PieceStatistics {
  std::size_t odometry_leaps = 0;  ///< changes of odometry that no motion explains
  std::size_t pieces = 0;          ///< of the trajectory: one more whenever tracking was lost
  std::size_t joins = 0;           ///< of pieces, by loops found without a prior pose
  std::size_t joins_refused = 0;   ///< such loops contradicted by walls or by another place
  std::size_t pieces_apart = 0;    ///< others not joined: beside the map, at poses of their own
  std::size_t short_apart = 0;     ///< of less than four nodes, not joined and not drawn …
  std::size_t scans_apart = 0;     ///< … and the scans in these, at predicted poses
};

/// Shares of rays that cross walls of a map a metre or more before their ends: some hundredths in a
/// map without mistakes, where people walk and doors move.
struct WallCrossings {
  double share = 0.0;          ///< of all
  double worst_stretch = 0.0;  ///< of those of 20 scans in succession: the largest
};

/// Called with the fraction done; return false to stop and keep the results so far.
using SlamProgress = std::function<bool(double fraction)>;

}  // namespace wayfare
