#pragma once

// SLAM with a Rao-Blackwellised particle filter (Zhang 2020, chapter 5; Grisetti et al. 2007) on
// radar, LiDAR or both. Every particle is a hypothesis of the whole trajectory with its own maps; a
// loop closes because the particle that returns consistently to its own walls explains them best.
//
// The steps are those of the source: augmented scans (10-40 radar frames as one), synchronisation,
// initialisation at the origin, motion by the product of wheel and gyro model, scan matching with
// rejection, weights and poses by τ = p(z | x, m) p(x | motion), map update, resampling when
// 1/Σw² < N/2.
//
// The scan matching of step 5, in a likelihood field of each particle's map, is by any matcher; the
// weights of step 6 need the field itself.
//
// RadarSlamStream is the same for measurements that arrive one by one, as on a robot.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/detail/owned.hpp>
#include <wayfare/core/gaussian.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/filter/rbpf.hpp>
#include <wayfare/map/inverse_lidar.hpp>
#include <wayfare/map/likelihood_field.hpp>
#include <wayfare/map/occupancy_grid.hpp>
#include <wayfare/match/pose_proposal.hpp>
#include <wayfare/motion/differential_drive_model.hpp>
#include <wayfare/sensors/measurements.hpp>
#include <wayfare/sensors/recording.hpp>
#include <wayfare/sensors/scans.hpp>
#include <wayfare/sensors/trajectory.hpp>
#include <wayfare/slam/detail/particle_matcher.hpp>
#include <wayfare/slam/radar_slam_options.hpp>
#include <wayfare/slam/scan_outcome.hpp>
#include <wayfare/sync/augmented_scans.hpp>

namespace wayfare {

/// Of a gyro's rate of turn: a Gaussian.
struct GyroBias {
  double mean_rad_s = 0.0;  ///< measured turn without turning
  double variance = 0.0;    ///< (rad/s)²
};

/// What follows from the trajectory of one particle.
struct RbpfMaps {
  OccupancyGrid lidar,   ///< map of the LiDAR
      radar;             ///< map of detections
  GyroBias gyro_bias{};  ///< given the particle's headings
};

/// Result of one scan.
struct RbpfOutcome {
  bool updated = false;               ///< whether it updated the filter; else its pose is predicted
  std::size_t matched = 0;            ///< particles whose match was accepted
  double mean_score = 0.0;            ///< of the matches, [0, 1]
  double effective_particles = 0.0;   ///< 1/Σw²
  bool resampled = false;             ///< after this scan
  std::size_t particles_refused = 0;  ///< their weight or pose was not finite: left without weight
  MatcherErrors matcher_errors;       ///< over all particles; the motion placed these
};

/// Counts of scans, matches and resamplings.
struct RbpfStatistics : PieceStatistics {
  std::size_t scans = 0,           ///< accepted
      updates = 0;                 ///< that updated the filter
  std::size_t without_points = 0;  ///< scans with too few points
  std::size_t matches = 0,         ///< accepted
      matches_refused = 0;         ///< rejected
  std::size_t matches_gated = 0;   ///< by a MatchGate, over all searches
  std::size_t resampled = 0;       ///< times
  std::size_t loops_closed = 0;    ///< that moved the path
  MatcherErrors matcher_errors;    ///< over all particles
};

/// Takes motion and scans in order of time. Not thread-safe; results do not depend on threads.
///
/// Where odometry leaps or LiDAR scans match no longer, a new piece of the trajectory begins beside
/// the map, with a filter of its own. It is joined as in graph SLAM, by LiDAR scans; the earlier
/// filter is then given its scans again, which takes as long as they took.
class RadarSlam {
 public:
  /// By exhaustive search and refinement.
  explicit RadarSlam(const RadarSlamOptions& options = {});
  /// By copies of a matcher, which must not depend on earlier matches. It finds the best particle's
  /// pose in a LiDAR scan. Those of the others are refined from there, in their own maps, and found
  /// by the matcher where they then agree worse; in radar scans it finds all. Where it returns an
  /// Error, or a result that is not valid, the particle is drawn from the motion.
  template <FieldMatcher M>
  explicit RadarSlam(const M& matcher, const RadarSlamOptions& options = {})
      : RadarSlam(detail::particle_matcher(matcher), options) {}

  /// Motion since the last call (or since the first scan). Its heading has the gyro's bias times
  /// `gyro_s` seconds in it: the time of the motion, by the gyro's share in the heading. The
  /// covariance is that without the bias. Returns an Error for non-finite values or a covariance
  /// that is not positive semi-definite.
  Result<void> move(const Gaussian<SE2d>& increment, double gyro_s = 0.0);

  /// A scan at the robot's current pose. Returns an Error and changes nothing for a scan without
  /// beams or with non-finite geometry, one not later than the last of its sensor, or earlier than
  /// any. Error (numerical) if the scan leaves no particle any weight: it is placed at the
  /// particles' poses, and the weights stay.
  Result<RbpfOutcome> add_lidar(const LaserScan& scan);
  /// Detections of one augmented radar scan, in the base frame at `time`; all must be finite.
  Result<RbpfOutcome> add_radar(LogTime time, const PointSet& points_base);

  /// Searches for joins of pieces from all of them; more scans may follow.
  void finish();

  /// One pose per accepted scan, along the best particle's trajectory: of each part of the map,
  /// those not joined beside the others.
  [[nodiscard]] Trajectory trajectory() const;
  /// Of the latest part alone, as are poses, maps and particles that follow.
  [[nodiscard]] Trajectory latest_trajectory() const;
  /// The same along another particle's, in the order of `particles()`.
  [[nodiscard]] Trajectory trajectory(std::size_t particle) const;
  /// The last of the best particle's poses; none before the first scan.
  [[nodiscard]] std::optional<StampedPose> pose() const;
  /// Of that pose relative to the first, a right perturbation: x and y along the base's axes, m²,
  /// and heading, rad². It is that of the path by `RbpfSensorOptions::drift` and the loops closed,
  /// of the particles about its end and of the match, or the motion, since the filter's last
  /// update.
  [[nodiscard]] Eigen::Matrix3d covariance() const;
  [[nodiscard]] const OccupancyGrid& lidar_map() const;  ///< of the best particle
  [[nodiscard]] const OccupancyGrid& radar_map() const;  ///< of the best particle
  /// Of the best particles of all parts.
  [[nodiscard]] RbpfMaps all_maps() const;
  /// Of every third LiDAR scan that is used for joins, through the walls of a map of these scans.
  [[nodiscard]] WallCrossings wall_crossings() const;
  /// Empty before the first scan.
  [[nodiscard]] std::span<const RbpfParticle<RbpfMaps>> particles() const;
  /// Of the particles, normalised.
  [[nodiscard]] std::span<const double> log_weights() const;
  [[nodiscard]] const RbpfStatistics& statistics() const;  ///< counts so far

 private:
  RadarSlam(const detail::MakeParticleMatcher& make, const RadarSlamOptions& options);

  class Engine;
  detail::Owned<Engine> engine_;
};

/// Sensors that the filter uses.
enum class SlamSensors {
  radar,  ///< augmented radar scans
  lidar,  ///< LiDAR scans
  both,   ///< each in its own map
};

/// Noise of wheels, gyro and odometry.
struct DeadReckoningOptions {
  DifferentialDriveModel wheels{.slip_m_per_sqrt_m = 0.02, .scale = 0.02};  ///< noise of the wheels
  GyroMotion gyro{.along_m_per_sqrt_m = 0.02,  ///< noise of the distance and the gyro
                  .scale = 0.02,
                  .angle_random_walk_rad_per_sqrt_s = 0.0015,
                  .bias_rad_s = 0.0};
  /// For recordings with odometry poses instead of wheels.
  MotionNoise odometry{0.03, 0.25, 0.02, Angle::degrees(3.0), 0.2, 0.1};
  /// With such recordings, scans in between are matched, and this travel and heading change between
  /// updates replace the filter's options: every update adds noise to the maps.
  double odometry_update_travel_m = 0.7;
  Angle odometry_update_turn = Angle::degrees(20);  ///< heading change
  /// Without wheels the windows searched are wide, and fine cells slow: cells of this size, m, and
  /// the two that follow then replace those of the LiDAR.
  double odometry_cell_m = 0.05;
  double odometry_point_sigma_m = 0.06;       ///< of a point about the cell it measures
  double odometry_independent_points = 60.0;  ///< of a scan; 0: all
  /// A wheel is stuck if it reports no motion while the other rolls this distance and the gyro does
  /// not measure the rotation which that implies.
  double stuck_after_m = 0.05;
};

/// A sensor fault to report to the user.
struct SensorFault {
  std::string what;  ///< in words
  LogTime from,      ///< its beginning
      until;         ///< its end
};

/// Results for a whole recording.
struct RadarSlamRun {
  Trajectory trajectory;                                 ///< one pose per accepted scan
  OccupancyGrid lidar_map,                               ///< the best particle's
      radar_map;                                         ///< likewise
  RbpfStatistics statistics;                             ///< counts
  std::vector<StampedPose> particles;                    ///< of the latest piece: their last poses
  std::vector<double> log_weights;                       ///< of the particles, normalised
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of the last pose, as RadarSlam's
  std::vector<Trajectory> paths;    ///< of the particles; with RadarSlamOptions::keep_paths only
  std::vector<SensorFault> faults;  ///< of wheels and gyro
  double gyro_bias_rad_s = 0.0;     ///< estimate at the end
  std::size_t refused_scans = 0;    ///< by add_lidar and add_radar
  std::string first_refusal;        ///< reason for the first of them
  WallCrossings crossings;          ///< of several pieces; else 0

  /// The map of the sensor that frees cells, if used.
  [[nodiscard]] const OccupancyGrid& map() const {
    return lidar_map.bounds() ? lidar_map : radar_map;
  }
};

/// Runs the filter over `recording`, with wheels and gyro if it has them, odometry and gyro or else
/// odometry. `sync` has the number of radar frames in a scan; the geometry is that of the
/// recording. Returns an Error if no scan of the selected sensors could be used.
Result<RadarSlamRun> run_radar_slam(const Recording& recording, RadarSlamOptions options,
                                    SlamSensors sensors, const SlamProgress& progress = {},
                                    const DeadReckoningOptions& reckoning = {},
                                    const SyncParams& sync = {});

/// Source of the motion between scans.
enum class MotionSource {
  wheels,    ///< and the gyro; odometry is ignored
  odometry,  ///< as poses; wheels and gyro are ignored
  none       ///< the pose is expected to stay, with a wide search
};

/// Filter, sensors and source of motion of a RadarSlamStream.
struct RadarSlamStreamOptions {
  RadarSlamOptions slam{};                       ///< with the laser's mounting pose
  SlamSensors sensors = SlamSensors::both;       ///< the scans used
  MotionSource motion = MotionSource::odometry;  ///< between scans
  DeadReckoningOptions reckoning{};              ///< noise of that motion
  /// The radar's mounting pose, the number of its frames in a scan, and how long to wait for a
  /// stream by the measurements' clock; with wheels all of its parameters apply.
  SyncParams sync{};
};

/// Takes each stream in its own order. Interleaving and batching of the streams do not change the
/// result as long as none lags by more than `sync.max_wait`. Not thread-safe.
class RadarSlamStream {
 public:
  /// By exhaustive search and refinement, as RadarSlam.
  explicit RadarSlamStream(const RadarSlamStreamOptions& options = {});
  /// By a matcher, as RadarSlam.
  template <FieldMatcher M>
  explicit RadarSlamStream(const M& matcher, const RadarSlamStreamOptions& options = {})
      : RadarSlamStream(RadarSlam(matcher, filter_options(options)), options) {}

  /// @{
  /// A measurement not later than the last of its stream, or than the last one processed, is
  /// refused and counted.
  void add(const WheelSample& sample);
  void add(const GyroSample& sample);
  void add(const OdometrySample& sample);
  void add(const RadarScan& scan);
  void add(const LaserScan& scan);
  /// @}
  /// Processes what is queued without further waiting. With wheels nothing may follow; otherwise
  /// later measurements are waited for again.
  void finish();

  /// Processes the next measurement in order of time, once its data is complete. Returns the time
  /// reached; nothing if data is missing.
  std::optional<LogTime> step();
  /// The stream that delays a scan ("odometry"); empty if none. Not determined with wheels.
  [[nodiscard]] std::string_view waits_for() const;

  /// As RadarSlam::finish.
  void join_pieces();

  [[nodiscard]] const RadarSlam& slam() const;  ///< the filter
  /// Of the sensor that frees cells, if used.
  [[nodiscard]] const OccupancyGrid& map() const;
  /// Results so far.
  [[nodiscard]] RadarSlamRun result() const;

 private:
  /// Of the filter, for the stream's source of motion.
  [[nodiscard]] static RadarSlamOptions filter_options(const RadarSlamStreamOptions& options);
  RadarSlamStream(RadarSlam slam, const RadarSlamStreamOptions& options);

  class Impl;
  detail::Owned<Impl> impl_;
};

}  // namespace wayfare
