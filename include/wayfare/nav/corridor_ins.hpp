#pragma once

// Dead reckoning by one gyro and the wheels, held by the walls of corridors (Liu, Atia, Karamat and
// Noureldin 2015): where there are walls, their normal points tell the errors of gyro and wheels;
// where there are none, what was learnt carries on.

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <wayfare/core/frame.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/inertial/reduced_ins.hpp>
#include <wayfare/match/lines.hpp>
#include <wayfare/nav/detail/corridor_motion.hpp>
#include <wayfare/sensors/recording.hpp>

namespace wayfare {

/// What gyro and wheels say of the time since the sample before.
struct MotionSample {
  LogTime time;
  double turn_rate_rad_s = 0.0;  ///< mean, counter-clockwise positive, bias and all
  double speed_m_s = 0.0;        ///< mean, forward
};

/// How long a wall is remembered.
enum class WallMemory {
  corridor,  ///< as long as it is tracked: its line is estimated with the rest
  one_scan,  ///< from scan to scan, as Liu 2015, (6), (7) and (25)
};

struct CorridorInsOptions {
  Transform2<frame::Base, frame::Laser> T_base_laser{};
  WallOptions walls{};
  WallMemory memory = WallMemory::corridor;
  CorridorNoise noise{};
  bool use_walls = true;             ///< off: dead reckoning alone
  bool use_end_walls = true;         ///< walls across tell how far along one is; side walls do not
  bool rest_calibrates = true;       ///< a gyro that turns while the wheels stand shows its bias
  Duration rest_after{500'000'000};  ///< of standing wheels
  /// Standard deviations at the start.
  double start_position_m = 1e-3, start_heading_rad = 1e-4;
  double start_bias_value_rad_s = 0.0;  ///< what is known of the bias beforehand
  double start_bias_rad_s = 0.035, start_drift_rad_s2 = 6e-6, start_scale = 0.005;
  double latitude_rad = 0.0;        ///< where the Earth's turn is to be taken out; 0: nowhere
  double gyro_range_rad_s = 1.745;  ///< a reading from here on is no measure of a turn
  double greatest_acceleration_m_s2 = 5.0;  ///< wheels that tell more slip
  Duration longest_slip{3'000'000'000};     ///< then the wheels are believed again
  /// What real walls add to each measurement, the same for many scans on end: they are neither
  /// straight nor one surface. 0 for walls that are.
  double wall_offset_sigma_m = 0.0;
  double wall_direction_sigma_rad = 0.0;
  /// Where corridors meet at right angles: by how much they miss them. 0 where nothing is known.
  double square_sigma_rad = 0.0;
  /// Relative error of a turn, for turn rates that come from wheels.
  double turn_error = 0.0;
  double gate_probability = 1e-4;    ///< that a good measurement is refused
  int rejections_to_reacquire = 5;   ///< scans in a row; the walls are then others
  Duration lost_after{600'000'000};  ///< without walls: the next ones are new
};

enum class WallOutcome { used, none, refused, reacquired };

struct CorridorScanUpdate {
  WallOutcome outcome = WallOutcome::none;
  std::optional<CorridorWalls> walls;  ///< as seen by the laser
  bool tracked = false;                ///< by prediction; else acquired
  bool end_used = false;
};

/// What was taken in, what was not, and why.
struct CorridorReport {
  std::size_t scans = 0, scans_with_walls = 0, scans_used = 0, end_walls_used = 0;
  std::size_t tracked = 0, acquisitions = 0, corridors = 0;
  std::size_t refused_walls = 0, refused_sides = 0, refused_end_walls = 0, not_parallel = 0;
  std::size_t saturated_samples = 0, slipping_samples = 0, rest_samples = 0, refused_samples = 0;
  Duration longest_outage{0};
  struct Event {
    LogTime time;
    std::string what;
  };
  std::vector<Event> events;  ///< the first hundred
};

/// A number and its standard deviation.
struct Estimate {
  double value = 0.0, sigma = 0.0;
};

/// The system, fed sample by sample. Not thread-safe.
class CorridorIns {
 public:
  explicit CorridorIns(const CorridorInsOptions& options = {}, const SE2d& start = {});
  ~CorridorIns();
  CorridorIns(CorridorIns&&) noexcept;
  CorridorIns& operator=(CorridorIns&&) noexcept;

  /// Refused, and nothing changed, where it is not finite or not after the one before.
  Result<void> add_motion(const MotionSample& sample);
  /// A scan at or after the last motion sample: the state is that of the sample, so that a scan
  /// should follow the sample of its time. Refused as motion is.
  Result<CorridorScanUpdate> add_scan(const LaserScan& scan);

  [[nodiscard]] SE2d pose() const;
  /// Of (x, y, heading) in the plane.
  [[nodiscard]] Eigen::Matrix3d pose_covariance() const;
  /// Of (x, y, heading, gyro bias, speed scale).
  [[nodiscard]] Eigen::Matrix<double, 5, 5> joint_covariance() const;
  [[nodiscard]] Estimate gyro_bias() const;    ///< rad/s
  [[nodiscard]] Estimate gyro_drift() const;   ///< rad/s²
  [[nodiscard]] Estimate speed_scale() const;  ///< metres rolled per metre told, less one
  [[nodiscard]] const CorridorVector& state() const;
  [[nodiscard]] const CorridorMatrix& covariance() const;
  [[nodiscard]] const CorridorReport& report() const;

 private:
  class Engine;
  std::unique_ptr<Engine> engine_;
};

/// The solution at one scan.
struct CorridorEpoch {
  LogTime time;
  SE2d pose;
  Eigen::Matrix3d pose_covariance = Eigen::Matrix3d::Zero();
  Estimate gyro_bias, speed_scale;
  /// Of (x, y, heading, gyro bias, speed scale).
  Eigen::Matrix<double, 5, 5> joint_covariance = Eigen::Matrix<double, 5, 5>::Zero();
  CorridorScanUpdate update;
};

struct CorridorRun {
  std::vector<CorridorEpoch> epochs;  ///< one for each scan taken
  CorridorReport report;
  std::size_t refused_scans = 0;
  std::string first_refusal;
};

/// Motion from gyro and wheels, or gyro and odometry, where the recording has them; else from
/// odometry alone. `added_bias_rad_s` is added to the turn rate: a bias to be found again.
[[nodiscard]] std::vector<MotionSample> motion_of(const Recording& recording,
                                                  double added_bias_rad_s = 0.0);

/// A whole recording at once. Fails where it has no scans or no motion.
[[nodiscard]] Result<CorridorRun> run_corridor_ins(
    const Recording& recording, std::span<const MotionSample> motion,
    const CorridorInsOptions& options = {}, const SE2d& start = {},
    const std::function<void(double)>& progress = {});

}  // namespace wayfare
