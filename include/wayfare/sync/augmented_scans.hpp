#pragma once

// One ordered stream from wheels, gyro, radar and laser (Zhang 2020, section 5.3.1): a time base of
// 20 Hz into which the scans' times are inserted, and radar frames, each too sparse for matching,
// accumulated to augmented scans by wheel odometry. And the bearing correction of a moving radar
// with time-division multiplexing.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/detail/eigen_alignment.hpp>
#include <wayfare/core/detail/owned.hpp>
#include <wayfare/core/frame.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/sensors/measurements.hpp>
#include <wayfare/sensors/point_set.hpp>
#include <wayfare/sensors/recording.hpp>
#include <wayfare/sensors/scans.hpp>

namespace wayfare {

/// The virtual antenna row whose transform gives the bearings, half a wavelength apart: every
/// transmitter with all receivers, one transmitter after the other, the first one's to the left.
struct RadarArray {
  double max_speed_m_s = 0.0;  ///< radial speeds wrap here; 0: unknown, no correction
  int transmitters = 2;        ///< in time-division multiplexing
  int receivers = 4;           ///< of each transmitter's row
  /// Points with a larger Doppler mismatch, as a fraction of max_speed_m_s, are not corrected.
  double max_mismatch = 0.25;

  /// Error of the bearing's sine per m/s of radial speed off the centre of its Doppler bin. The
  /// device compensates a point's motion between transmitters (Bechter, Roos and Waldschmidt 2017)
  /// with the speed of the bin; a phase of π δv / (T v_max) per transmitter remains. The transform
  /// interprets the slope of these steps, R(T² − 1)/(T²R² − 1) of a step for each of the TR
  /// antennas, as a bearing.
  [[nodiscard]] double sine_per_m_s() const {
    const double T = transmitters, R = receivers;
    if (!(max_speed_m_s > 0.0) || transmitters < 2) return 0.0;
    return R * (T * T - 1.0) / (T * T * R * R - 1.0) / (T * max_speed_m_s);
  }
};

/// `point` on a static object, measured by a radar that moves with `velocity_m_s` (its own axes),
/// with its bearing corrected to that of a radar at rest.
[[nodiscard]] inline RadarPoint compensate_bearing(const RadarPoint& point,
                                                   const Eigen::Vector2d& velocity_m_s,
                                                   const RadarArray& array) {
  const auto x = static_cast<double>(point.x_m), y = static_cast<double>(point.y_m);
  const double range = std::hypot(x, y);
  const double per_m_s = array.sine_per_m_s();
  if (per_m_s == 0.0 || !(range > 0.0) || !std::isfinite(point.doppler_m_s)) return point;
  const double radial = -(velocity_m_s.x() * x + velocity_m_s.y() * y) / range;
  const double mismatch =
      std::remainder(radial - static_cast<double>(point.doppler_m_s), 2.0 * array.max_speed_m_s);
  if (!(std::abs(mismatch) <= array.max_mismatch * array.max_speed_m_s)) return point;
  const double sine = std::clamp(y / range - per_m_s * mismatch, -1.0, 1.0);
  RadarPoint corrected = point;
  corrected.x_m = static_cast<float>(std::copysign(range * std::sqrt(1.0 - sine * sine), x));
  corrected.y_m = static_cast<float>(range * sine);
  return corrected;
}

/// Whether the radial speed of `point`, measured by a radar that moves with `velocity_m_s` (its own
/// axes), differs from that of a static object by more than `tolerance_m_s`; both wrap at the
/// array's largest speed, where that is known.
[[nodiscard]] inline bool is_moving(const RadarPoint& point, const Eigen::Vector2d& velocity_m_s,
                                    const RadarArray& array, double tolerance_m_s) {
  const auto x = static_cast<double>(point.x_m), y = static_cast<double>(point.y_m);
  const double range = std::hypot(x, y);
  if (!(range > 0.0) || !std::isfinite(point.doppler_m_s)) return false;
  const double radial = -(velocity_m_s.x() * x + velocity_m_s.y() * y) / range;
  double mismatch = static_cast<double>(point.doppler_m_s) - radial;
  if (array.max_speed_m_s > 0.0) mismatch = std::remainder(mismatch, 2.0 * array.max_speed_m_s);
  return std::abs(mismatch) > tolerance_m_s;
}

/// Time base, gathering of radar frames and geometry of a RobotSynchroniser.
struct SyncParams {
  Duration period{50'000'000};  ///< of the time base
  std::size_t scans = 20;       ///< radar frames gathered into one; 10 to 40 in the source
  std::size_t min_scans = 3;    ///< fewer, before a gap in the radar stream, are dropped
  double min_range_m = 0.0;     ///< nearer radar points are dropped
  double max_range_m = 1e9;     ///< farther radar points are dropped
  float min_snr_db = 0.0F;      ///< weaker radar points are dropped
  /// Radar points whose radial speed differs by more from that of a static object, by the wheels or
  /// odometry, are moving and dropped; covers a Doppler bin and a half. 0: all are kept.
  double moving_m_s = 0.0;
  /// How long a step waits for a stream that lags the others; then the stream counts as silent.
  Duration max_wait{500'000'000};
  /// Between wheel or gyro samples further apart than this, the motion is unknown.
  Duration largest_gap{300'000'000};
  /// A longer silence of all streams is one step: a damaged stamp does not give a step for each
  /// period of the years up to it.
  Duration longest_silence = std::chrono::hours(1);
  double wheel_base_m = 0.0;                                ///< as in the recording
  Transform2<frame::Base, frame::Radar> T_base_radar = {};  ///< mounting of the radar
  /// Bearings are corrected for the robot's motion where the array's largest speed is known.
  RadarArray array = {};
};

/// Consecutive radar frames as one scan, in the robot's pose at the time of the first.
struct AugmentedScan {
  LogTime time;           ///< of the first frame
  LogTime until;          ///< of the last
  std::size_t scans = 0;  ///< number of frames gathered
  PointSet points;        ///< in the robot's own axes (base) at `time`
};

/// Measurements since the previous step, up to `time`.
struct SyncedStep {
  LogTime time;        ///< end of the step
  Duration since{0};   ///< since the previous step; 0 in the first
  WheelSample wheels;  ///< metres rolled since the previous step, interpolated
  GyroSample gyro;     ///< mean rate since the previous step
  /// False where the wheels were silent or not finite. They then count nothing; the distance over
  /// the gap is added to the step that reaches the next sample.
  bool wheels_known = false;
  bool gyro_known = false;                  ///< false where the gyro was silent; its rate is then 0
  std::optional<AugmentedScan> radar = {};  ///< whose first frame is at `time`
  std::optional<LaserScan> laser = {};      ///< taken at `time`

  /// Distance of the robot's centre since the previous step, m.
  [[nodiscard]] double forward_m() const { return 0.5 * (wheels.left_m + wheels.right_m); }
};

/// Counts of measurements that were not used.
struct SyncStatistics {
  /// Not later than the previous one of its stream, or than a step, or at the end of the range of
  /// LogTime.
  std::size_t refused_late = 0;
  std::size_t refused_not_finite = 0;  ///< wheels and gyro
  std::size_t dropped_scans = 0;       ///< radar frames in groups below min_scans
};

/// Each stream must be in order of time; how the streams are interleaved and chunked does not
/// change the steps as long as none lags by more than `max_wait` minus its own period. A step
/// depends on nothing later than itself, except for its augmented scan, which depends on data up to
/// its last frame and on the wheels' first sample from there on.
class RobotSynchroniser {
 public:
  /// Requires a positive period and number of scans.
  explicit RobotSynchroniser(const SyncParams& params);

  /// @{
  /// False where the measurement was rejected.
  bool push(const WheelSample& sample);
  bool push(const GyroSample& sample);
  bool push(const RadarScan& scan);
  bool push(const LaserScan& scan);
  /// @}
  /// Ends the streams: the remaining steps are available at once.
  void finish();

  /// The next step, in order of time, once it is complete.
  [[nodiscard]] std::optional<SyncedStep> next();

  /// Counts so far.
  [[nodiscard]] const SyncStatistics& statistics() const;

 private:
  class Impl;
  detail::Owned<Impl> impl_;
};

/// `params` with the sensor geometry of the recording.
[[nodiscard]] SyncParams sync_params(const Recording& recording, SyncParams params = {});

/// All steps of a recording, and optionally the counts of rejected measurements.
[[nodiscard]] std::vector<SyncedStep> synchronise(const Recording& recording,
                                                  const SyncParams& params,
                                                  SyncStatistics* statistics = nullptr);

}  // namespace wayfare
