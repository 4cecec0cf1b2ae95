#pragma once

// Inertial navigation with GNSS ranges and range rates, tightly coupled: the 23-state error-state
// Kalman filter of Zhang 2020, section 3.1. Also accepts position fixes (loosely coupled).

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/detail/owned.hpp>
#include <wayfare/core/random.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/inertial/imu_noise.hpp>
#include <wayfare/inertial/ins_state.hpp>
#include <wayfare/nav/odometer.hpp>
#include <wayfare/nav/phase_change.hpp>
#include <wayfare/sensors/measurements.hpp>
#include <wayfare/sensors/trajectory.hpp>

namespace wayfare {

namespace detail {
struct InsHistoryAccess;
}

/// The part of the errors of ranges and fixes that is correlated in time (atmosphere, orbits,
/// multipath): a Gauss-Markov process for each satellite, and for each axis of the fixes, estimated
/// beside the states. The variances are those of the measurements, which depend on elevation and
/// C/N0. It decays with time and with the path of the antenna: at rest multipath stays.
struct CorrelatedErrorOptions {
  double share = 0.0;          ///< of a measurement's variance, [0, 1]; 0: all of it is white noise
  double tau_s = 300.0;        ///< correlation time, s
  double distance_m = 1000.0;  ///< correlation length of the antenna's path, m
};

/// Sensors, mounting, measurements and gaps of a GnssIns.
struct GnssInsOptions {
  ImuNoise imu;              ///< of the inertial unit
  ReceiverClockNoise clock;  ///< of the receiver's clock
  /// Mounting: rotates the unit's axes to body (forward-right-down).
  SO3d q_body_imu;
  /// From the unit to the antenna, body axes, m.
  Eigen::Vector3d antenna_lever_arm_m = Eigen::Vector3d::Zero();
  /// Added to the unit's times to convert them to log time, s.
  double imu_time_offset_s = 0.0;
  /// Multiplies every range's standard deviation (Zhang 2020, table 2, parameter 33).
  double range_sigma_scale = 1.0;
  /// Measurements with a normalised innovation above this, σ, are rejected …
  double gate_sigma = 5.0;
  /// … but after this time of rejections, s, the covariance is inflated until measurements pass
  /// again.
  double gate_reopen_s = 3.0;
  /// Correlated errors of ranges and fixes. With them the filter cannot be smoothed.
  CorrelatedErrorOptions correlated;
  /// Above 0: innovations above this, σ, count with a variance increased until they are of this
  /// size, as with Student's distribution, so that outliers neither pull the estimate nor make it
  /// more certain.
  double robust_sigma = 0.0;
  /// Non-holonomic constraint with fewer than four satellites: lateral and vertical velocity of the
  /// body are about zero. Not for vehicles that can move sideways.
  bool non_holonomic_in_outage = true;
  double non_holonomic_sigma_mps = 0.1;  ///< of either velocity
  /// Zero-velocity and zero-turn-rate updates when the unit detects standstill.
  bool zero_velocity_updates = true;
  /// Fraction of the gyro's sample-to-sample variation beyond its own noise that is treated as an
  /// error of every reading, since vibration above half the sampling rate is aliased. 0: well
  /// damped or filtered unit; 1: all of it is noise.
  double gyro_vibration_share = 0.5;
  /// After a longer gap of inertial readings, s, the solution is reinitialised.
  double max_imu_gap_s = 10.0;
  /// Unmeasured acceleration and turn rate during gaps of more than three sampling intervals (added
  /// to the covariance), m/s², rad/s.
  double gap_acceleration_mps2 = 2.0;
  double gap_turn_rate_radps = 0.3;  ///< unmeasured turn rate during such a gap
  /// Largest delay of a GNSS measurement, s.
  double max_lateness_s = 3.0;
  /// Without a given start, the heading is initialised from the GNSS velocity above this speed,
  /// m/s, with this standard deviation, rad.
  double start_speed_mps = 3.0;
  double start_heading_sigma_rad = 0.1;  ///< of a heading from the course
  /// Above 0: keeps what GnssIns::lagged() needs of the last seconds, about 8 kB for each reading.
  double smoothing_lag_s = 0.0;
  /// Also starts at rest, level by gravity with an unknown heading, and on a straight by the
  /// differences of positions without velocities. Once the heading is known the filter starts again
  /// with it.
  bool start_without_velocity = false;
  /// Present: wheel speeds are used, and the filter has six more states.
  std::optional<OdometerOptions> odometer;
  /// Present: carrier phases of range epochs are used, and the filter has four more states.
  std::optional<CarrierPhaseOptions> carrier_phase;
};

/// The filter's estimate at one instant.
struct GnssInsEstimate {
  NavState nav;                     ///< of the inertial unit, not the antenna
  Eigen::Vector3d gyro_bias_radps,  ///< rad/s, the unit's axes
      accel_bias_mps2,              ///< m/s²
      gyro_scale,                   ///< relative
      accel_scale;                  ///< relative
  double clock_bias_m = 0.0,        ///< receiver clock
      clock_drift_mps = 0.0;        ///< its rate
  /// Of the 23 errors of ins_state.
  Eigen::Matrix<double, ins_state::kSize, ins_state::kSize> covariance;
  std::optional<OdometerEstimate> odometer;  ///< with GnssInsOptions::odometer
};

/// Innovation of one measurement and its standard deviation.
struct InnovationRecord {
  /// What was measured.
  enum class Kind : std::uint8_t {
    range,       ///< to a satellite
    range_rate,  ///< to a satellite
    position,    ///< of a fix, one axis
    velocity,    ///< of a fix, one axis
    constraint,  ///< velocity of the vehicle
    standstill,  ///< velocity or turn rate at rest
    phase,       ///< change of a carrier phase, to a satellite
    wheels,      ///< speed of the wheels
  };
  static constexpr std::size_t kKinds = 8;  ///< number of kinds
  LogTime time;                             ///< of the measurement
  Kind kind = Kind::range;                  ///< what was measured
  SatelliteId satellite;                    ///< of a range, range rate or phase
  double innovation = 0.0;                  ///< measured − predicted, SI units
  double sigma = 0.0;                       ///< its predicted standard deviation
  bool accepted = false;                    ///< passed the gate and was used
};

/// A given initial state with standard deviations.
struct GnssInsStart {
  NavState nav;                     ///< of the inertial unit
  double position_sigma_m = 5.0;    ///< each of north, east and down
  double velocity_sigma_mps = 0.5;  ///< each of north, east and down
  double level_sigma_rad = 0.02;    ///< roll and pitch
  /// About the vertical. Above 1 rad the heading is unknown until motion gives it; meanwhile the
  /// filter does not use it.
  double heading_sigma_rad = 0.1;
  /// Gyro bias in the unit's axes; σ of zero: unknown.
  Eigen::Vector3d gyro_bias_radps = Eigen::Vector3d::Zero();
  double gyro_bias_sigma_radps = 0.0;  ///< each axis
};

/// A start around the truth: its errors are drawn from the standard deviations of `start`, those of
/// the attitude about north, east and down.
[[nodiscard]] inline GnssInsStart drawn_start(const NavState& truth, GnssInsStart start, Rng& rng) {
  const auto draw = [&rng](double x, double y, double z) {
    const double a = rng.normal(), b = rng.normal(), c = rng.normal();
    return Eigen::Vector3d(x * a, y * b, z * c);
  };
  const double p = start.position_sigma_m, v = start.velocity_sigma_mps;
  const double level = start.level_sigma_rad;
  start.nav = truth;
  start.nav.position = geodetic_from_ned(draw(p, p, p), truth.position);
  start.nav.velocity_ned_mps += draw(v, v, v);
  start.nav.q_nb = SO3d::exp(draw(level, level, start.heading_sigma_rad)) * truth.q_nb;
  return start;
}

/// Everything a run needs, each stream in order of time.
struct GnssInsRecording {
  std::vector<ImuSample> imu;           ///< readings of the unit
  std::vector<RangeEpoch> ranges;       ///< corrected ranges, for tight coupling
  std::vector<GnssFix> fixes;           ///< positions of a receiver, for loose coupling
  std::optional<GnssInsStart> start;    ///< absent: from GNSS velocity and levelling
  std::vector<WheelSpeed> wheels = {};  ///< used with GnssInsOptions::odometer
};

/// An event of the filter: a gap, a late epoch, a reset.
struct GnssInsNotice {
  LogTime time;       ///< of the event
  std::string text;   ///< what happened
  bool lost = false;  ///< the solution contradicted the measurements and was given up
};

/// One output of a run: the state and the standard deviation of each of its 23 errors.
struct GnssInsPoint {
  NavState nav;                                     ///< of the inertial unit
  Eigen::Matrix<float, ins_state::kSize, 1> sigma;  ///< of each error of ins_state
  Eigen::Matrix<float, 12, 1> imu_errors;  ///< gyro bias, accel bias, gyro scale, accel scale
  double clock_bias_m = 0.0,               ///< receiver clock
      clock_drift_mps = 0.0;               ///< its rate
};

/// The solution of a recording.
struct GnssInsResult {
  std::vector<GnssInsPoint> points;           ///< at the unit's rate, since the start
  std::vector<InnovationRecord> innovations;  ///< of every measurement, rejected ones too
  std::vector<GnssInsNotice> notices;         ///< events, in order of time
};

/// The filter, processing one measurement at a time in order of arrival. Late range epochs,
/// fixes and wheel speeds are handled by replay from recent states. The solution is reinitialised
/// if all inertial readings of a second are late, since the unit's clock was set back, and if it
/// leaves the range of the navigation equations: heights of −100 to 10 000 km, speeds below 100
/// km/s, more than a kilometre from the poles.
class GnssIns {
 public:
  /// Not started.
  explicit GnssIns(const GnssInsOptions& options);
  /// A copy continues by itself from the same state.
  GnssIns(const GnssIns& other);
  GnssIns(GnssIns&&) = default;                   ///< leaves nothing usable behind
  GnssIns& operator=(const GnssIns& other);       ///< as the copy
  GnssIns& operator=(GnssIns&& other) = default;  ///< leaves nothing usable behind
  ~GnssIns() = default;

  /// Starts at the first inertial reading at or after the given time, at most
  /// GnssInsOptions::max_imu_gap_s later. A start that is not finite or not on the Earth is not
  /// used; a notice says so.
  void start(const GnssInsStart& start);
  /// Whether it has a solution.
  [[nodiscard]] bool started() const;
  /// What is missing for a start, and what would help; empty once started.
  [[nodiscard]] std::string missing() const;

  /// An error says why a measurement was not used; the filter is unchanged.
  Result<void> add(const ImuSample& sample);
  /// A range epoch; late ones are replayed.
  Result<void> add(const RangeEpoch& epoch);
  /// A fix; late ones are replayed.
  Result<void> add(const GnssFix& fix);
  /// A wheel speed; late ones are replayed. Those before the start, and more than ten a second, are
  /// left out. Needs GnssInsOptions::odometer.
  Result<void> add(const WheelSpeed& wheels);

  /// Needs started().
  [[nodiscard]] GnssInsEstimate estimate() const;
  /// The same without correlations, cheap enough for every reading. Needs started().
  [[nodiscard]] GnssInsPoint point() const;
  /// The estimate GnssInsOptions::smoothing_lag_s before the newest reading, by all measurements
  /// since (fixed-lag smoothing; Bierman 1973). Nothing before it has run for that long, and with
  /// GnssInsOptions::correlated errors, which are not smoothed.
  [[nodiscard]] std::optional<GnssInsEstimate> lagged() const;
  /// Innovations and notices since the last call.
  [[nodiscard]] std::vector<InnovationRecord> take_innovations();
  /// Notices since the last call, in order of time.
  [[nodiscard]] std::vector<GnssInsNotice> take_notices();

 private:
  class Filter;
  friend struct detail::InsHistoryAccess;
  detail::Owned<Filter> filter_;
};

/// Called regularly with the fraction done, in [0, 1].
using GnssInsProgress = std::function<void(double)>;

/// Runs a whole recording. One that does not start is run again with
/// GnssInsOptions::start_without_velocity. Fails when it is empty, never starts (the message says
/// what is missing), or is cancelled.
[[nodiscard]] Result<GnssInsResult> run_gnss_ins(const GnssInsRecording& recording,
                                                 const GnssInsOptions& options,
                                                 const GnssInsProgress& progress = {},
                                                 std::stop_token stop = {});

/// The same, smoothed: each point by all measurements of the recording, those after it included
/// (fixed-interval smoothing; Bierman 1973). Innovations and notices are the filter's. Takes about
/// three times as long; memory for the filter's state every few seconds, and for its steps between
/// two of those, grows with the square root of the length. Measurements are taken in order of time.
/// `each`, if any, gets every estimate with its whole covariance, the newest first.
[[nodiscard]] Result<GnssInsResult> smooth_gnss_ins(
    const GnssInsRecording& recording, const GnssInsOptions& options,
    const GnssInsProgress& progress = {}, std::stop_token stop = {},
    const std::function<void(const GnssInsEstimate&)>& each = {});

}  // namespace wayfare
