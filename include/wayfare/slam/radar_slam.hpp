#pragma once

// SLAM with a Rao-Blackwellised particle filter (Zhang 2020, chapter 5; Grisetti et al. 2007) on
// radar, on LiDAR, or on both: every particle is a hypothesis of the whole way with maps of its
// own; loops close because the particle that comes home to its own walls explains them best.
//
// The steps are those of the source: augmented scans (10-40 radar frames as one), synchronisation,
// initialisation at the origin, motion by the product of wheel and gyro model, scan matching with
// rejection, weights and poses by τ = p(z | x, m) p(x | motion), map update, resampling when
// 1/Σw² < N/2.

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/gaussian.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/filter/rbpf.hpp>
#include <wayfare/map/detection_grid.hpp>
#include <wayfare/map/inverse_lidar.hpp>
#include <wayfare/map/occupancy_field.hpp>
#include <wayfare/map/occupancy_grid.hpp>
#include <wayfare/match/pose_proposal.hpp>
#include <wayfare/motion/differential_drive_model.hpp>
#include <wayfare/motion/motion_noise.hpp>
#include <wayfare/sensors/recording.hpp>
#include <wayfare/slam/scan_outcome.hpp>

namespace wayfare {

/// What a sensor's scans are to the filter.
struct RbpfSensorOptions {
  /// Cells remember a few scans: walls of one round outlast what the next adds beside them.
  OccupancyGridOptions grid{.min_probability = 0.002, .max_probability = 0.999};
  OccupancyFieldOptions field{};
  /// Where given, scans are matched in the density of detections instead: for a sensor that frees
  /// no cell. What one detection counts is what it was mapped with.
  std::optional<DetectionViewOptions> density{};
  /// A scan's points err together: this many count, against the motion and in the weights. More:
  /// surer of its matches, and sooner of one particle.
  double independent_points = 60.0;
  /// Scans with fewer points are not matched: the motion model stands.
  std::size_t fewest_points = 10;
  /// Agreement with the map in [0, 1] below which a match is refused.
  double least_score = 0.4;
  /// Agreement below which a scan is also looked for where the best particle's matches say the
  /// robot is, by that particle as far about as this, the motion believed half as much; a match
  /// found there must explain scan and motion better by so many nats. Zero metres: never.
  double tracked_score = 0.65;
  double wide_m = 0.8;
  Angle wide_turn = Angle::degrees(50);
  double wide_nats = 5.0;
  /// A correction of more than these is refused.
  double max_correction_m = 1.2;
  Angle max_turn_correction = Angle::degrees(60);
  /// The search reaches this many standard deviations of the motion.
  double search_sigmas = 3.0;
  /// Farther points are not matched, m.
  double max_range_m = 20.0;
  /// Between neighbouring points, m.
  double point_spacing_m = 0.1;
  /// Travel and turn since its sensor's last after which a scan goes into the maps too. A map of
  /// walls that grows with every scan draws each to where the one before it was believed.
  double map_travel_m = 0.2;
  Angle map_turn = Angle::degrees(8);
  /// A match is first sought with every second point, third, and so on, where there are more than
  /// this many; all place it then. Zero: with all.
  std::size_t search_points = 60;
};

/// Few points, half of them ghosts or clutter, and bearings of a degree or two: what stays decides,
/// and to tell it a map must go on counting, every scan that was moved for.
[[nodiscard]] inline RbpfSensorOptions radar_sensor_options() {
  RbpfSensorOptions o;
  o.grid = detection_map();
  o.density = DetectionViewOptions{.max_detections = 30.0};
  o.independent_points = 60.0;
  o.fewest_points = 15;
  o.least_score = 0.05;
  o.wide_m = 0.0;
  o.point_spacing_m = 0.0;
  o.map_travel_m = 0.05;
  o.search_points = 0;
  return o;
}

struct RadarSlamOptions {
  std::size_t particles = 30;
  std::uint64_t seed = 1;
  int threads = 1;  ///< particles worked on at a time; the result is the same for any number

  Transform2<frame::Base, frame::Laser> T_base_laser{};
  RbpfSensorOptions lidar{};
  RbpfSensorOptions radar = radar_sensor_options();
  /// Beams that graze a wall free it; a hit outweighs many of them.
  InverseLidarModel lidar_model{.p_free = 0.4, .p_hit = 0.8};
  /// Occupancy a single radar detection gives its cell; no cell is freed, radar sees through
  /// things. Little, because an augmented scan holds many frames of the same reflector: a place
  /// must be seen again and again before it counts.
  double radar_hit_probability = 0.52;

  /// Travel, turn and time since its sensor's last after which a scan is taken up; those in between
  /// are placed by motion.
  double update_travel_m = 0.02;
  Angle update_turn = Angle::degrees(0.5);
  double update_time_s = 5.0;
  /// LiDAR scans in between are matched with the best particle's map: that places them, and says
  /// where the robot has moved more than motion knows.
  bool match_between = false;

  PoseProposalOptions proposal{.samples = 500, .headings = 20, .divide_by_proposal = true};
  double resample_below = 0.5;  ///< of the number of particles, for 1/Σw²
};

/// The maps one particle has made.
struct RbpfMaps {
  OccupancyGrid lidar, radar;
};

/// What became of a scan.
struct RbpfOutcome {
  bool taken_up = false;    ///< else placed by the motion since the one before
  std::size_t matched = 0;  ///< particles whose match was believed
  double mean_score = 0.0;  ///< of the matches, [0, 1]
  /// By how much they turned the robot further than motion did; the particles' weighted mean.
  Angle turn_correction{};
  double effective_particles = 0.0;
  bool resampled = false;
  std::size_t particles_refused = 0;  ///< their weight or pose was not finite: left without weight
};

struct RbpfStatistics {
  std::size_t scans = 0, taken_up = 0;
  std::size_t without_points = 0;                ///< scans with too few points
  std::size_t matches = 0, matches_refused = 0;  ///< over all particles
  std::size_t resampled = 0;
};

/// The system, fed with motion and scans in order of time. Not thread-safe; results do not depend
/// on threads.
class RadarSlam {
 public:
  explicit RadarSlam(const RadarSlamOptions& options = {});
  ~RadarSlam();
  RadarSlam(RadarSlam&&) noexcept;
  RadarSlam& operator=(RadarSlam&&) noexcept;

  /// The robot moved like this since the last call (or since the first scan). Refused: not finite,
  /// a covariance that is not semi-definite.
  Result<void> move(const Gaussian<SE2d>& increment);

  /// Scans at the robot's present place. Refused, without changing anything: a scan without beams
  /// or with other than finite geometry; one not later than the one before of the same sensor, or
  /// earlier than any. An Error (numerical) where the scan leaves no particle any weight: it is
  /// placed where the particles are, which keep the weights they had.
  Result<RbpfOutcome> add_lidar(const LaserScan& scan);
  /// Detections of one augmented radar scan, in the robot's own frame at `time`. Refused also where
  /// one is not finite.
  Result<RbpfOutcome> add_radar(LogTime time, const PointSet& points_base);

  /// One pose a scan taken, along the best particle's way.
  [[nodiscard]] Trajectory trajectory() const;
  /// The last of them; nothing before the first scan.
  [[nodiscard]] std::optional<StampedPose> pose() const;
  [[nodiscard]] const OccupancyGrid& lidar_map() const;
  [[nodiscard]] const OccupancyGrid& radar_map() const;
  /// Empty before the first scan.
  [[nodiscard]] std::span<const RbpfParticle<RbpfMaps>> particles() const;
  [[nodiscard]] std::span<const double> log_weights() const;
  [[nodiscard]] const RbpfStatistics& statistics() const;

 private:
  class Engine;
  std::unique_ptr<Engine> engine_;
};

/// Which sensors the filter listens to.
enum class SlamSensors { radar, lidar, both };

/// A gyro's bias, learnt from what scan matching has to correct all the time: a motion that always
/// errs to the same side would bend every map it helps to make. As maps turn along with the motion
/// they are made by, only part of it is learnt.
struct GyroBiasOptions {
  /// Standard deviation before anything is known, rad/s. 0: the gyro has none, nothing is learnt.
  double prior_rad_s = 0.004;
  /// Of one matched heading, rad.
  double heading_rad = 0.007;
  /// What is learnt is never believed to be surer than this, rad/s: maps that turned along with
  /// the motion tell nothing of it.
  double least_rad_s = 0.001;
  /// How long what was learnt counts, s: a bias wanders.
  double remembered_s = 300.0;
  /// Larger corrections are finds, not drift, rad.
  double largest_rad = 0.05;
  /// How long the bias left over errs to the same side, s: as long as the robot sees the stretch of
  /// map it bends, about. Longer: headings come from matches rather than from the gyro.
  double unchecked_s = 20.0;
};

/// How far wheels, gyro and ready-made odometry are believed.
struct DeadReckoningOptions {
  DifferentialDriveModel wheels{.slip_m_per_sqrt_m = 0.02, .scale = 0.02};
  GyroMotion gyro{.along_m_per_sqrt_m = 0.02,
                  .scale = 0.02,
                  .angle_random_walk_rad_per_sqrt_s = 0.0015,
                  .bias_rad_s = 0.0};
  GyroBiasOptions gyro_bias{};
  /// For recordings that give poses instead of wheels.
  MotionNoise odometry{0.03, 0.25, 0.02, Angle::degrees(3.0), 0.2, 0.1};
  /// With such recordings scans in between are matched, and taken up after this travel and turn,
  /// whatever the filter's options say: every update draws some noise into the maps.
  double odometry_update_travel_m = 0.7;
  Angle odometry_update_turn = Angle::degrees(20);
  /// A wheel counts as stuck when it counts nothing while the other rolls this far, and the gyro
  /// does not see the turn that would mean.
  double stuck_after_m = 0.05;
};

/// Something a sensor did that a user should hear of.
struct SensorFault {
  std::string what;
  LogTime from, until;
};

/// A whole recording at once.
struct RadarSlamRun {
  Trajectory trajectory;               ///< one pose a scan taken
  OccupancyGrid lidar_map, radar_map;  ///< the best particle's
  RbpfStatistics statistics;
  std::vector<StampedPose> particles;  ///< where all of them ended
  std::vector<double> log_weights;     ///< theirs, normalised
  std::vector<SensorFault> faults;
  double gyro_bias_rad_s = 0.0;  ///< as learnt at the end
  std::size_t refused_scans = 0;
  std::string first_refusal;

  /// The map of the sensor that frees cells, where there is one.
  [[nodiscard]] const OccupancyGrid& map() const {
    return lidar_map.bounds() ? lidar_map : radar_map;
  }
};

/// Runs the filter over `recording`: from wheels and gyro where it has them, else from its
/// odometry. An Error where no scan of the sensors asked for could be used.
Result<RadarSlamRun> run_radar_slam(const Recording& recording, RadarSlamOptions options,
                                    SlamSensors sensors, const SlamProgress& progress = {},
                                    const DeadReckoningOptions& reckoning = {});

}  // namespace wayfare
