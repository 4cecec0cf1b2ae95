#pragma once

// Inertial navigation with GNSS ranges and range rates, tightly coupled: the 23-state error-state
// Kalman filter of Zhang 2020, section 3.1. Also takes finished fixes (loosely coupled).

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/result.hpp>
#include <wayfare/core/so3.hpp>
#include <wayfare/inertial/imu_noise.hpp>
#include <wayfare/inertial/ins_state.hpp>
#include <wayfare/sensors/gnss.hpp>
#include <wayfare/sensors/imu.hpp>
#include <wayfare/sensors/nav_state.hpp>

namespace wayfare {

struct GnssInsOptions {
  ImuNoise imu;
  ReceiverClockNoise clock;
  /// How the unit is mounted: rotates its axes to body (forward-right-down).
  SO3d q_body_imu;
  /// From the unit to the antenna, body axes, m.
  Eigen::Vector3d antenna_lever_arm_m = Eigen::Vector3d::Zero();
  /// Added to the unit's times to bring them to the log's, s.
  double imu_time_offset_s = 0.0;
  /// Multiplies every range's standard deviation (Zhang 2020, table 2, parameter 33).
  double range_sigma_scale = 1.0;
  /// A measurement whose normalised innovation exceeds this many σ is refused...
  double gate_sigma = 5.0;
  /// ...but after this long without an accepted one the filter doubts itself instead: its
  /// covariance grows until measurements fit again, s.
  double gate_reopen_s = 3.0;
  /// Lateral and vertical velocity of the body are about zero while fewer than four satellites are
  /// seen; off for whatever can move sideways.
  bool non_holonomic_in_outage = true;
  double non_holonomic_sigma_mps = 0.1;
  /// Standing still, seen by the unit itself, holds velocity and turn rate at zero.
  bool zero_velocity_updates = true;
  /// Of the spread by which a gyro's readings differ from one to the next beyond its own noise,
  /// this share is taken as an error of every reading: vibration faster than half the sampling rate
  /// comes back as slow turning. 0: the unit is damped or filtered well; 1: all of it is noise.
  double gyro_vibration_share = 0.5;
  /// A gap of the unit longer than this ends the inertial solution until it can start anew, s.
  double max_imu_gap_s = 10.0;
  /// Readings that are missing for longer than three usual intervals: the vehicle may meanwhile
  /// have accelerated and turned by about this much (added to the covariance), m/s², rad/s.
  double gap_acceleration_mps2 = 2.0;
  double gap_turn_rate_radps = 0.3;
  /// How late a GNSS measurement may arrive and still be used, s.
  double max_lateness_s = 3.0;
  /// Without a given start: the heading is taken from the GNSS velocity once the vehicle is this
  /// fast, m/s, and trusted to this much, rad.
  double start_speed_mps = 3.0;
  double start_heading_sigma_rad = 0.1;
};

/// What the filter holds at one instant.
struct GnssInsEstimate {
  NavState nav;  ///< of the inertial unit, not the antenna
  Eigen::Vector3d gyro_bias_radps, accel_bias_mps2, gyro_scale, accel_scale;
  double clock_bias_m = 0.0, clock_drift_mps = 0.0;
  Eigen::Matrix<double, ins_state::kSize, ins_state::kSize> covariance;
};

/// What one measurement did: its innovation against the innovation's own σ.
struct InnovationRecord {
  enum class Kind : std::uint8_t { range, range_rate, position, velocity, constraint, standstill };
  LogTime time;
  Kind kind = Kind::range;
  SatelliteId satellite;
  double innovation = 0.0;
  double sigma = 0.0;
  bool accepted = false;
};

/// A known start; standard deviations of what is not known exactly.
struct GnssInsStart {
  NavState nav;
  double position_sigma_m = 5.0;
  double velocity_sigma_mps = 0.5;
  double level_sigma_rad = 0.02;
  double heading_sigma_rad = 0.1;
  /// Of the gyros in the unit's axes, where it is known; σ of zero: it is not.
  Eigen::Vector3d gyro_bias_radps = Eigen::Vector3d::Zero();
  double gyro_bias_sigma_radps = 0.0;
};

/// Everything a run needs, each stream in order of time.
struct GnssInsRecording {
  std::vector<ImuSample> imu;
  std::vector<RangeEpoch> ranges;
  std::vector<GnssFix> fixes;
  std::optional<GnssInsStart> start;  ///< absent: from GNSS velocity and levelling
};

/// Something the filter met and survived: a gap, a late epoch, a reset.
struct GnssInsNotice {
  LogTime time;
  std::string text;
};

/// One output of a run: the state and the standard deviation of each of its 23 errors.
struct GnssInsPoint {
  NavState nav;
  Eigen::Matrix<float, ins_state::kSize, 1> sigma;
  Eigen::Matrix<float, 12, 1> imu_errors;  ///< gyro bias, accel bias, gyro scale, accel scale
  double clock_bias_m = 0.0, clock_drift_mps = 0.0;
};

struct GnssInsResult {
  std::vector<GnssInsPoint> points;  ///< at the unit's rate, from the start on
  std::vector<InnovationRecord> innovations;
  std::vector<GnssInsNotice> notices;
};

/// The filter itself, fed one measurement at a time in the order they arrive. A range epoch or fix
/// may arrive late: recent states are kept and replayed.
class GnssIns {
 public:
  explicit GnssIns(const GnssInsOptions& options);
  ~GnssIns();
  GnssIns(GnssIns&&) noexcept;
  GnssIns& operator=(GnssIns&&) noexcept;

  void start(const GnssInsStart& start);
  [[nodiscard]] bool started() const;

  /// An error says why a measurement was not used; the filter is unharmed.
  Result<void> add(const ImuSample& sample);
  Result<void> add(const RangeEpoch& epoch);
  Result<void> add(const GnssFix& fix);

  /// Needs started().
  [[nodiscard]] GnssInsEstimate estimate() const;
  /// The same without correlations, cheap enough for every reading. Needs started().
  [[nodiscard]] GnssInsPoint point() const;
  /// Innovations and notices since the last call.
  [[nodiscard]] std::vector<InnovationRecord> take_innovations();
  [[nodiscard]] std::vector<GnssInsNotice> take_notices();

 private:
  class Filter;
  std::unique_ptr<Filter> filter_;
};

/// Called now and then with the fraction done, in [0, 1].
using GnssInsProgress = std::function<void(double)>;

/// Runs a whole recording. Fails when it is empty, never starts, or is cancelled.
[[nodiscard]] Result<GnssInsResult> run_gnss_ins(const GnssInsRecording& recording,
                                                 const GnssInsOptions& options,
                                                 const GnssInsProgress& progress = {},
                                                 std::stop_token stop = {});

}  // namespace wayfare
