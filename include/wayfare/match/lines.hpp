#pragma once

// Detection and tracking of corridor walls in laser scans: parallel lines, described by their
// normal points (Liu, Atia, Karamat and Noureldin, Journal of Navigation, 2015).

#include <optional>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/detail/eigen_alignment.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/match/detail/beams.hpp>
#include <wayfare/sensors/scans.hpp>

namespace wayfare {

/// Foot of the perpendicular from the laser to a line, in the laser's polar axes (Liu 2015, fig.
/// 4; x forward here, counter-clockwise). The line is { p : p · (cos α, sin α) = ρ }, ρ > 0.
struct NormalPoint {
  double rho_m = 0.0;                                    ///< distance of the line from the laser
  Angle alpha;                                           ///< direction of its normal, from x
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< of (ρ, α), m and rad
};

/// One side of a corridor, as seen in one scan.
struct Wall {
  double offset_m = 0.0;  ///< along the corridor's left-hand normal: left walls > 0, right < 0
  int beams = 0;          ///< number of beams that hit it
  double begin_m = 0.0;   ///< first …
  double end_m = 0.0;     ///< … and last visible position along the corridor, from the laser
};

/// One or both walls of a corridor in one scan, in the laser's frame.
struct CorridorWalls {
  Angle direction;           ///< along the walls; acquisition gives it within (−90°, 90°]
  std::optional<Wall> left,  ///< nothing where not seen
      right;                 ///< on the other side
  /// Of (direction, left offset, right offset), rad and m. Both walls share the direction, so
  /// their offsets are correlated. Zero for a wall that is not present.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  /// A wall across the corridor ahead, with its own direction: it gives the position along it.
  std::optional<NormalPoint> end;
  /// Fraction of the beams expected to hit the walls that did, in [0, 1].
  double correlation = 0.0;
  /// False if two walls were seen that are not parallel; then only the longer is returned.
  bool parallel = true;

  /// Distance between the walls; 0 unless both are present.
  [[nodiscard]] double width_m() const {
    return left && right ? left->offset_m - right->offset_m : 0.0;
  }
  /// Of a wall that is present.
  [[nodiscard]] NormalPoint left_point() const;
  /// Of a wall that is present.
  [[nodiscard]] NormalPoint right_point() const;
};

/// The walls in the frame of a laser that moved by `motion` (in its previous axes), with unchanged
/// covariances.
[[nodiscard]] CorridorWalls moved(const CorridorWalls& walls, const SE2d& motion);
/// The same walls with the direction reversed, left and right exchanged.
[[nodiscard]] CorridorWalls reversed(const CorridorWalls& walls);

/// An edge of a side wall, as of a door or a recess: where the range jumps.
struct WallEdge {
  double along_m = 0.0;    ///< along the corridor, from the laser
  double sigma_m = 0.0;    ///< of it, by the spacing of the beams
  bool left = false;       ///< on the left wall
  bool gap_ahead = false;  ///< the wall ends here, in the corridor's direction; else it begins
};

/// Direction of most walls of a building whose walls meet at right angles.
struct SquareDirection {
  Angle direction;         ///< of one of the two families of walls, in the laser's frame
  double length_m = 0.0;   ///< of the segments along or across it, within 2.5°
  double total_m = 0.0;    ///< of all segments
  double sigma_rad = 0.0;  ///< spread of the segments about it
};

/// Noise, segments and search windows of a WallDetector.
struct WallOptions {
  double range_noise_m = 0.005;  ///< σ along a beam; larger: wider windows, larger covariances
  double flatness_m = 0.002;     ///< σ of a wall's deviation from a line
  double max_range_m = 12.0;     ///< farther returns are not used
  double split_m = 0.025;  ///< a run of points is split where it deviates more from its chord …
  double break_m = 0.5;    ///< … and where neighbours are farther apart
  double min_segment_m = 0.25;                ///< shorter runs are no wall
  int min_segment_points = 5;                 ///< runs of fewer points are no wall
  double min_support_m = 1.2;                 ///< total length of the segments of both walls
  double min_width_m = 0.7;                   ///< of a corridor whose two walls are seen
  double max_width_m = 8.0;                   ///< of a corridor whose two walls are seen
  Angle parallel_within = Angle::degrees(4);  ///< largest angle between segments of a corridor
  double capture_m = 0.5;                     ///< search distance of a wall from its segments
  double tracking_m = 0.15;                   ///< search distance of a wall from its prediction
  double min_correlation = 0.25;              ///< tracking is lost below
  int min_beams = 8;                          ///< on a wall, else it is not used
  double min_beam_fraction = 0.2;             ///< of the beams expected on a wall
  bool end_walls = true;                      ///< detect walls across the corridor
};

/// Finds walls in scans; returns nothing if there are none. Reuses the beams' directions and its
/// buffers from scan to scan, so it is not thread-safe.
class WallDetector {
 public:
  /// Keeps the options.
  explicit WallDetector(const WallOptions& options = {}) : options_(options) {}

  /// Fast acquisition without a prediction: split-and-merge segments, the direction and offsets
  /// with the greatest total length, total least squares on the points of both walls. `near`: the
  /// direction, within 25°, if known.
  [[nodiscard]] std::optional<CorridorWalls> acquire(const LaserScan& scan,
                                                     std::optional<Angle> near = {});
  /// Acquisition by search over heading and lateral distance as in Liu 2015, section 5: a replica
  /// of each wall is correlated with the scan. Slower; also finds walls of short segments.
  [[nodiscard]] std::optional<CorridorWalls> search(const LaserScan& scan,
                                                    std::optional<Angle> near = {});
  /// Tracking: only the fit, in a window around the predicted walls.
  [[nodiscard]] std::optional<CorridorWalls> track(const LaserScan& scan,
                                                   const CorridorWalls& predicted);
  /// The curve fitting that Liu 2015, section 7.1, compares with: a line through each window of 25
  /// points, the most frequent direction and offsets of their histograms. No wall across.
  [[nodiscard]] std::optional<CorridorWalls> fit_windows(const LaserScan& scan,
                                                         std::optional<Angle> near = {});
  /// Edges of `walls`, found in this scan, where the range jumps by at least `jump_m` and beams are
  /// dense. Not of a wall's visible ends, which are no jumps.
  [[nodiscard]] std::vector<WallEdge> edges(const LaserScan& scan, const CorridorWalls& walls,
                                            double jump_m = 0.2);
  /// The direction within `within` of `near` that most line segments are along or across, also of
  /// walls that do not form a corridor. Nothing if their segments are shorter than min_support_m.
  [[nodiscard]] std::optional<SquareDirection> square_direction(const LaserScan& scan, Angle near,
                                                                Angle within);

 private:
  WallOptions options_;
  lines::Beams beams_;
};

}  // namespace wayfare
