#pragma once

// Dead reckoning by one gyro and wheel odometry, aided by corridor walls (Liu, Atia, Karamat and
// Noureldin 2015): the normal points of walls calibrate gyro and odometry, and bridge sections
// without walls.

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <wayfare/core/detail/owned.hpp>
#include <wayfare/core/frame.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/inertial/ins_model.hpp>
#include <wayfare/match/lines.hpp>
#include <wayfare/nav/detail/corridor_motion.hpp>
#include <wayfare/sensors/recording.hpp>

namespace wayfare {

/// Gyro and wheel measurements since the previous sample.
struct MotionSample {
  LogTime time;                  ///< at the end of the interval
  double turn_rate_rad_s = 0.0;  ///< mean, counter-clockwise positive, including bias
  double speed_m_s = 0.0;        ///< mean, forward
};

/// How long a wall is part of the state.
enum class WallMemory {
  corridor,  ///< while tracked: its line is estimated jointly
  one_scan,  ///< from scan to scan, as Liu 2015, (6), (7) and (25)
};

/// How walls are found in a scan.
enum class WallSearch {
  tracking,  ///< tracked from a prediction, acquired from segments
  windows,   ///< WallDetector::fit_windows(), the curve fitting that Liu 2015 compares with
};

/// Mounting, start, walls and limits of a CorridorIns.
struct CorridorInsOptions {
  Transform2<frame::Base, frame::Laser> T_base_laser{};  ///< mounting of the laser
  WallOptions walls{};                                   ///< of the detector
  WallMemory memory = WallMemory::corridor;              ///< how long a wall is part of the state
  WallSearch search = WallSearch::tracking;              ///< how walls are found in a scan
  /// Scans sooner after the last one used are skipped; 0: all are used. Liu 2015 updates at 5 Hz.
  Duration least_scan_interval{0};
  CorridorNoise noise{};                ///< of gyro, wheels and slip
  bool use_walls = true;                ///< false: dead reckoning only
  bool use_end_walls = true;            ///< walls across the corridor observe the position along it
  bool rest_calibrates = true;          ///< the gyro measures its bias while the wheels stand
  Duration rest_after{500'000'000};     ///< time of standing wheels
  double start_position_m = 1e-3,       ///< standard deviation at the start, along each axis
      start_heading_rad = 1e-4;         ///< standard deviation
  double start_bias_value_rad_s = 0.0;  ///< prior of the bias
  double start_bias_rad_s = 0.035,      ///< standard deviation
      start_drift_rad_s2 = 6e-6,        ///< standard deviation
      start_scale = 0.005;              ///< standard deviation, relative
  double latitude_rad = 0.0;            ///< for the Earth rate correction; 0: none
  double gyro_range_rad_s = 1.745;      ///< readings of at least this rate are saturated
  double greatest_acceleration_m_s2 = 5.0;  ///< above: wheels slip
  Duration longest_slip{3'000'000'000};     ///< after which the wheels are used again
  /// Model error of real walls, which are not perfectly straight and is correlated over scans. 0
  /// for ideal walls.
  double wall_offset_sigma_m = 0.0;
  double wall_direction_sigma_rad = 0.0;  ///< of the direction of such a wall; 0 for ideal walls
  /// Corridors meet at right angles with this standard deviation; 0: not assumed.
  double square_sigma_rad = 0.0;
  /// With square_sigma_rad: the heading relative to all walls of each scan, also of rooms, with
  /// this standard deviation; 0: not used.
  double building_sigma_rad = 0.0;
  /// Edges of doors and recesses along side walls observe the position along the corridor, with
  /// this standard deviation, where no wall across does; 0: not used.
  double marks_sigma_m = 0.0;
  /// Relative error of the turn rate, for rates from wheels.
  double turn_error = 0.0;
  double gate_probability = 1e-4;    ///< false rejection probability
  int rejections_to_reacquire = 5;   ///< consecutive scans, after which new walls are acquired
  Duration lost_after{600'000'000};  ///< without walls, after which new walls are acquired
};

/// What became of a scan's walls.
enum class WallOutcome {
  used,        ///< they corrected the state
  none,        ///< none were found
  refused,     ///< they contradict their prediction
  reacquired,  ///< new ones became part of the state
  skipped,     ///< not looked for: sooner than CorridorInsOptions::least_scan_interval
};

/// The walls of one scan and their use.
struct CorridorScanUpdate {
  WallOutcome outcome = WallOutcome::none;  ///< what became of them
  std::optional<CorridorWalls> walls;       ///< in the laser frame
  bool tracked = false;                     ///< by prediction; else acquired
  bool end_used = false;                    ///< the wall across the corridor corrected the position
  bool marks_used = false;                  ///< edges of doors and recesses corrected the position
  bool heading_used = false;  ///< the heading relative to the building corrected the state
};

/// Counts of used and rejected measurements, and events.
struct CorridorReport {
  std::size_t scans = 0,              ///< in order of time, without skipped ones
      skipped_scans = 0,              ///< by least_scan_interval
      scans_with_walls = 0,           ///< with walls
      scans_used = 0,                 ///< with both or one used
      end_walls_used = 0;             ///< across the corridor
  std::size_t tracked = 0,            ///< scans with predicted walls
      acquisitions = 0,               ///< scans with acquired walls
      corridors = 0;                  ///< corridors entered
  std::size_t headings_used = 0,      ///< scans that gave a heading relative to the building
      marks_used = 0,                 ///< scans whose edges gave the position along the corridor
      refused_marks = 0;              ///< scans whose edges contradict the prediction
  std::size_t refused_walls = 0,      ///< scans rejected
      refused_sides = 0,              ///< one of two walls
      refused_end_walls = 0,          ///< across the corridor
      not_parallel = 0;               ///< scans of two such
  std::size_t saturated_samples = 0,  ///< by gyro_range_rad_s
      slipping_samples = 0,           ///< by the wheels' acceleration
      rest_samples = 0,               ///< gave the bias
      refused_samples = 0;            ///< not finite or late
  Duration longest_outage{0};         ///< of scans without walls
  /// What happened, in words.
  struct Event {
    LogTime time;      ///< of the scan or sample
    std::string what;  ///< text
  };
  std::vector<Event> events;  ///< the first hundred
};

/// A value and its standard deviation.
struct Estimate {
  double value = 0.0,  ///< estimated
      sigma = 0.0;     ///< standard deviation
};

/// The filter, processed sample by sample. Not thread-safe. With walls the filter is reinitialised
/// when heading or position become unknown (standard deviations above 10 rad or 1 km), as after a
/// long gap in the motion: with standard deviations of √10 rad and 100 m, the gyro errors of the
/// start, and new walls. An event reports it.
class CorridorIns {
 public:
  /// At `start` in the plane, with the standard deviations of the options.
  explicit CorridorIns(const CorridorInsOptions& options = {}, const SE2d& start = {});

  /// Rejected without effect if not finite, beyond 1000 rad/s or m/s, or not after the previous
  /// sample.
  Result<void> add_motion(const MotionSample& sample);
  /// A scan at or after the last motion sample. The state is that of the sample, so a scan should
  /// follow the sample of its time. Rejected if not after the previous scan.
  Result<CorridorScanUpdate> add_scan(const LaserScan& scan);

  /// Of the robot in the plane, at the last motion sample.
  [[nodiscard]] SE2d pose() const;
  /// Of (x, y, heading) in the plane.
  [[nodiscard]] Eigen::Matrix3d pose_covariance() const;
  /// Of (x, y, heading, gyro bias, speed scale).
  [[nodiscard]] Eigen::Matrix<double, 5, 5> joint_covariance() const;
  [[nodiscard]] Estimate gyro_bias() const;    ///< rad/s
  [[nodiscard]] Estimate gyro_drift() const;   ///< rad/s²
  [[nodiscard]] Estimate speed_scale() const;  ///< true distance per measured distance, less one
  /// All blocks of the filter's state.
  [[nodiscard]] const CorridorState& state() const;
  /// Of the errors of state().
  [[nodiscard]] const SquareOf<CorridorState>& covariance() const;
  /// Counts and events so far.
  [[nodiscard]] const CorridorReport& report() const;

 private:
  class Engine;
  detail::Owned<Engine> engine_;
};

/// The solution at one scan.
struct CorridorEpoch {
  LogTime time;                                               ///< of the scan
  SE2d pose;                                                  ///< of the robot
  Eigen::Matrix3d pose_covariance = Eigen::Matrix3d::Zero();  ///< of (x, y, heading)
  Estimate gyro_bias,                                         ///< rad/s
      speed_scale;  ///< true distance per measured one, less one
  /// Of (x, y, heading, gyro bias, speed scale).
  Eigen::Matrix<double, 5, 5> joint_covariance = Eigen::Matrix<double, 5, 5>::Zero();
  CorridorScanUpdate update;  ///< what became of the scan's walls
};

/// The solution of a recording.
struct CorridorRun {
  std::vector<CorridorEpoch> epochs;  ///< one per accepted scan
  CorridorReport report;              ///< counts and events
  std::size_t refused_scans = 0;      ///< not accepted
  std::string first_refusal;          ///< message of the first of them; empty: none
};

/// Motion from gyro and wheels, or gyro and odometry, if recorded; else from odometry alone. Wheel
/// and odometry samples that are not finite are left out; empty if none remain. `added_bias_rad_s`
/// is added to the turn rate, to test its estimation.
[[nodiscard]] std::vector<MotionSample> motion_of(const Recording& recording,
                                                  double added_bias_rad_s = 0.0);

/// Processes a whole recording. Fails without scans or motion.
[[nodiscard]] Result<CorridorRun> run_corridor_ins(
    const Recording& recording, std::span<const MotionSample> motion,
    const CorridorInsOptions& options = {}, const SE2d& start = {},
    const std::function<void(double)>& progress = {});

}  // namespace wayfare
