#pragma once

// One ordered stream out of wheels, gyro, radar and laser (Zhang 2020, section 5.3.1): a time base
// of 20 Hz into which the scans' times are inserted, and radar frames, each too sparse to be
// matched, gathered into augmented scans by the wheels' odometry.

#include <chrono>
#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include <wayfare/core/frame.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/sensors/laser_scan.hpp>
#include <wayfare/sensors/point_set.hpp>
#include <wayfare/sensors/radar_scan.hpp>
#include <wayfare/sensors/recording.hpp>
#include <wayfare/sensors/wheels.hpp>
#include <wayfare/sync/detail/radar_bearing.hpp>

namespace wayfare {

struct SyncParams {
  Duration period{50'000'000};   ///< of the time base
  std::size_t scans = 20;        ///< radar frames gathered into one; 10 to 40 in the source
  std::size_t fewest_scans = 3;  ///< fewer, where the radar fell silent, are thrown away
  double min_range_m = 0.0;      ///< nearer radar points are left out
  double max_range_m = 1e9;      ///< farther radar points are left out
  float min_snr_db = 0.0F;       ///< weaker radar points are left out
  /// How long a step waits for a stream that is behind the others; then the stream counts as
  /// silent.
  Duration patience{500'000'000};
  /// Wheel or gyro samples further apart than this leave the time between them unknown.
  Duration largest_gap{300'000'000};
  double wheel_base_m = 0.0;  ///< as in the recording
  Transform2<frame::Base, frame::Radar> T_base_radar = {};
  /// Bearings are set right for the robot's own motion where the array's largest speed is known.
  RadarArray array = {};
};

/// Consecutive radar frames as one: their points where the robot stood at the first one's time.
struct AugmentedScan {
  LogTime time;   ///< of the first frame
  LogTime until;  ///< of the last
  std::size_t scans = 0;
  PointSet points;  ///< in the robot's own axes (base) at `time`
};

/// What happened since the step before, up to `time`.
struct SyncedStep {
  LogTime time;
  Duration since{0};   ///< of the step before; 0 in the first
  WheelSample wheels;  ///< metres rolled since the step before, by interpolation
  GyroSample gyro;     ///< mean rate since the step before
  /// False where the wheels were silent, or not finite. They then count nothing; what a later
  /// sample counts over the silence comes with the step that reaches it.
  bool wheels_known = false;
  bool gyro_known = false;  ///< false where the gyro was; its rate is then 0
  std::optional<AugmentedScan> radar = {};
  std::optional<LaserScan> laser = {};

  [[nodiscard]] double forward_m() const { return 0.5 * (wheels.left_m + wheels.right_m); }
  [[nodiscard]] double forward_m_s() const {
    return since > Duration::zero() ? forward_m() / to_seconds(since) : 0.0;
  }
};

struct SyncStatistics {
  std::size_t refused_late = 0;  ///< not later than the one before of its stream, or than a step
  std::size_t refused_not_finite = 0;  ///< wheels and gyro
  std::size_t thrown_away_scans = 0;   ///< radar frames of which too few came together
};

/// Takes each stream in its own order; how the streams are interleaved, and in what portions they
/// come, does not change the steps as long as none lags by more than `patience` less its own
/// period. A step depends on nothing later than itself but for its augmented scan, which depends on
/// nothing later than its last frame, and on the wheels' first sample from there on.
class RobotSynchroniser {
 public:
  explicit RobotSynchroniser(const SyncParams& params);
  ~RobotSynchroniser();
  RobotSynchroniser(RobotSynchroniser&&) noexcept;
  RobotSynchroniser& operator=(RobotSynchroniser&&) noexcept;

  /// False where the measurement was refused.
  bool push(const WheelSample& sample);
  bool push(const GyroSample& sample);
  bool push(const RadarScan& scan);
  bool push(const LaserScan& scan);
  /// Nothing more will come: what waits is given without waiting.
  void finish();

  /// The next step, in order of time, once all that belongs to it is there.
  [[nodiscard]] std::optional<SyncedStep> next();

  [[nodiscard]] const SyncStatistics& statistics() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

/// What the recording says of how its sensors are mounted, filled in.
[[nodiscard]] SyncParams sync_params(const Recording& recording, SyncParams params = {});

/// All steps of a recording, and what had to be refused where that is asked for.
[[nodiscard]] std::vector<SyncedStep> synchronise(const Recording& recording,
                                                  const SyncParams& params,
                                                  SyncStatistics* statistics = nullptr);

}  // namespace wayfare
