#pragma once

// The walls of a corridor in one laser scan, as Liu, Atia, Karamat and Noureldin (Journal of
// Navigation, 2015) use them: parallel lines by their normal points, acquired, then tracked.

#include <memory>
#include <optional>

#include <Eigen/Core>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/sensors/laser_scan.hpp>

namespace wayfare {

/// Foot of the perpendicular from the laser to a line, in the laser's polar axes (Liu 2015, fig.
/// 4; x forward here, counter-clockwise). The line is { p : p · (cos α, sin α) = ρ }, ρ > 0.
struct NormalPoint {
  double rho_m = 0.0;
  Angle alpha;
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< of (ρ, α), m and rad
};

struct Wall {
  double offset_m = 0.0;  ///< along the corridor's left-hand normal: left walls > 0, right < 0
  int beams = 0;          ///< that met it
  double begin_m = 0.0;   ///< along the corridor from the laser, where it is first seen …
  double end_m = 0.0;     ///< … and last
};

/// One or both walls of a corridor as one scan sees them. Angles and places are the laser's.
struct CorridorWalls {
  Angle direction;  ///< along the walls; acquisition gives it within (−90°, 90°]
  std::optional<Wall> left, right;
  /// Of (direction, left offset, right offset), rad and m. Both walls share the direction, so
  /// their offsets are correlated. Zero where there is no wall.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  /// A wall across, in front, with a direction of its own: it tells how far along one is.
  std::optional<NormalPoint> end;
  /// Share of the beams that should have met the walls that did, in [0, 1].
  double correlation = 0.0;
  /// False where two walls were seen that are not parallel: the longer alone is then given.
  bool parallel = true;

  [[nodiscard]] double width_m() const {
    return left && right ? left->offset_m - right->offset_m : 0.0;
  }
  /// Of a wall that is there.
  [[nodiscard]] NormalPoint left_point() const { return normal_point(1, *left); }
  [[nodiscard]] NormalPoint right_point() const { return normal_point(2, *right); }

 private:
  [[nodiscard]] NormalPoint normal_point(int row, const Wall& wall) const;
};

/// What a laser that moved by `motion` (in its axes before) should see: covariances stay.
[[nodiscard]] CorridorWalls moved(const CorridorWalls& walls, const SE2d& motion);
/// The same walls with the direction turned round, left and right exchanged.
[[nodiscard]] CorridorWalls turned_round(const CorridorWalls& walls);

struct WallOptions {
  double range_noise_m = 0.005;  ///< along a beam; larger: looser windows, larger covariances
  double flatness_m = 0.002;     ///< how far a wall is from a line, added across it
  double reach_m = 12.0;         ///< returns from farther are not used
  double split_m = 0.025;        ///< a run of points is split where it bows by more
  double break_m = 0.5;          ///< and where neighbours are farther apart
  double least_segment_m = 0.25;
  int least_segment_points = 5;
  double least_support_m = 1.2;  ///< length of straight pieces that make walls, both together
  double least_width_m = 0.7;    ///< of a corridor both of whose walls are seen
  double greatest_width_m = 8.0;
  Angle parallel_within = Angle::degrees(4);  ///< pieces that differ by less may be one corridor's
  double capture_m = 0.5;           ///< how far from the pieces that showed it a wall is looked for
  double tracking_m = 0.15;         ///< how far from its prediction a wall is looked for
  double least_correlation = 0.25;  ///< tracking ends below: the walls are to be acquired anew
  int least_beams = 8;              ///< of a wall
  double least_share = 0.2;         ///< of the beams that should meet a wall, that do
  bool end_walls = true;            ///< look for a wall across
};

/// Finds walls in scans; keeps the beams' directions and its buffers from scan to scan. Not
/// thread-safe. Nothing is returned where no wall was found: an everyday outcome.
class WallDetector {
 public:
  explicit WallDetector(const WallOptions& options = {});
  ~WallDetector();
  WallDetector(WallDetector&&) noexcept;
  WallDetector& operator=(WallDetector&&) noexcept;

  /// Acquisition from nothing, the fast way: straight pieces by splitting and merging, the
  /// direction and offsets most of their length agrees on, total least squares on both walls'
  /// points together. `near` (within 25°) where the direction is known.
  [[nodiscard]] std::optional<CorridorWalls> acquire(const LaserScan& scan,
                                                     std::optional<Angle> near = {});
  /// Acquisition by search over heading and lateral distance as in Liu 2015, section 5: a replica
  /// of each wall is correlated with the scan. Slower; finds walls that stand in short pieces.
  [[nodiscard]] std::optional<CorridorWalls> search(const LaserScan& scan,
                                                    std::optional<Angle> near = {});
  /// Tracking: the fit alone, in a window around walls predicted for this scan.
  [[nodiscard]] std::optional<CorridorWalls> track(const LaserScan& scan,
                                                   const CorridorWalls& predicted);

 private:
  class Engine;
  std::unique_ptr<Engine> engine_;
};

}  // namespace wayfare
