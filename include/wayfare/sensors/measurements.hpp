#pragma once

// The output of a GNSS receiver: observations, corrected ranges, fixes.

#include <compare>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/geodesy.hpp>
#include <wayfare/core/time.hpp>

namespace wayfare {

/// One reading of an inertial unit in its own axes. Specific force: what accelerometers measure, +g
/// upward at rest.
struct ImuSample {
  LogTime time;                                                   ///< of the reading
  Eigen::Vector3d angular_rate_radps = Eigen::Vector3d::Zero();   ///< rad/s
  Eigen::Vector3d specific_force_mps2 = Eigen::Vector3d::Zero();  ///< m/s²
};

/// One instant of a nine-axis unit (magnetic, angular rate, gravity) in its own axes. A missing
/// measurement is NaN.
struct MargSample {
  /// A missing component.
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

  LogTime time;                                                           ///< of the reading
  Eigen::Vector3d angular_rate_radps = Eigen::Vector3d::Constant(kNone);  ///< rad/s
  /// What accelerometers measure: +g upward at rest.
  Eigen::Vector3d specific_force_mps2 = Eigen::Vector3d::Constant(kNone);
  Eigen::Vector3d magnetic_field_uT = Eigen::Vector3d::Constant(kNone);  ///< µT
};

using MargRecording = std::vector<MargSample>;  ///< in order of time

/// Distance rolled by each of two driven wheels since the previous sample, metres.
struct WheelSample {
  LogTime time;          ///< at the end of the interval
  double left_m = 0.0;   ///< m, forward positive
  double right_m = 0.0;  ///< m, forward positive
};

/// The mean turn rate since the previous sample, counter-clockwise positive.
struct GyroSample {
  LogTime time;                  ///< at the end of the interval
  double turn_rate_rad_s = 0.0;  ///< rad/s
};

/// A satellite navigation system, in the order of arrays by system.
enum class GnssSystem : std::uint8_t {
  gps,      ///< GPS
  glonass,  ///< GLONASS
  galileo,  ///< Galileo
  beidou,   ///< BeiDou
};
inline constexpr int kGnssSystems = 4;  ///< number of systems

/// A satellite by system and number (PRN; the slot for GLONASS), from 1.
struct SatelliteId {
  GnssSystem system = GnssSystem::gps;  ///< of the satellite
  std::uint8_t number = 0;              ///< PRN or slot, from 1
  /// By system, then by number.
  auto operator<=>(const SatelliteId&) const = default;
};

/// One satellite's raw code and Doppler measurement on one signal. NaN: not measured.
struct SatelliteObservation {
  SatelliteId satellite;  ///< observed
  /// M, with the receiver clock's bias.
  double pseudorange_m = std::numeric_limits<double>::quiet_NaN();
  double doppler_hz = std::numeric_limits<double>::quiet_NaN();      ///< positive when approaching
  double carrier_cycles = std::numeric_limits<double>::quiet_NaN();  ///< carrier phase
  double cn0_dbhz = std::numeric_limits<double>::quiet_NaN();        ///< carrier-to-noise density
  double carrier_hz = std::numeric_limits<double>::quiet_NaN();      ///< the signal's frequency
  /// The phase may have jumped since the epoch before, or is known but for half cycles.
  bool phase_interrupted = false;
};

/// All satellites of one reception time on the receiver's clock.
struct ObservationEpoch {
  Time<GpsClock> time;                           ///< of reception, by the receiver's clock
  std::vector<SatelliteObservation> satellites;  ///< each satellite at most once per signal
};

/// A range and range rate without satellite clock, relativity, group delay and atmosphere:
///   range = |p − satellite position| + clock bias + noise,
///   rate  = uᵀ(satellite velocity − v) + clock drift + noise, u from receiver to satellite,
///   phase = |p − satellite position| + clock bias + a constant of the satellite + noise.
/// The satellite is where it was at transmission, in the Earth-fixed axes of the time of reception
/// (so its position and velocity include the Sagnac effect). NaN: not measured.
struct CorrectedRange {
  SatelliteId satellite;                                        ///< ranged to
  Eigen::Vector3d position_ecef_m = Eigen::Vector3d::Zero();    ///< m, at transmission
  Eigen::Vector3d velocity_ecef_mps = Eigen::Vector3d::Zero();  ///< m/s, at transmission
  double range_m = std::numeric_limits<double>::quiet_NaN();  ///< m, with the receiver clock's bias
  /// m/s, positive when receding.
  double range_rate_mps = std::numeric_limits<double>::quiet_NaN();
  double range_sigma_m = 1.0;                                  ///< standard deviation, m
  double range_rate_sigma_mps = 0.1;                           ///< standard deviation, m/s
  double cn0_dbhz = std::numeric_limits<double>::quiet_NaN();  ///< carrier-to-noise density
  double phase_m = std::numeric_limits<double>::quiet_NaN();   ///< carrier phase, m
  double phase_sigma_m = 0.005;                                ///< standard deviation, m
  bool phase_interrupted = false;  ///< the constant may differ from that of the epoch before
};

/// The corrected ranges of one instant.
struct RangeEpoch {
  LogTime time;                            ///< of reception
  std::vector<CorrectedRange> satellites;  ///< in the order observed
};

/// Speed of a vehicle by the turns of its wheels; negative backwards.
struct WheelSpeed {
  LogTime time;            ///< of validity
  double speed_mps = 0.0;  ///< of the axle
};

/// A receiver's own position, and velocity where it reports one.
struct GnssFix {
  LogTime time;                                                              ///< of validity
  Geodetic position;                                                         ///< of the antenna
  Eigen::Matrix3d position_covariance_ned_m2 = Eigen::Matrix3d::Identity();  ///< m²
  std::optional<Eigen::Vector3d> velocity_ned_mps;                           ///< m/s
  Eigen::Matrix3d velocity_covariance_ned = Eigen::Matrix3d::Identity();     ///< (m/s)²
};

}  // namespace wayfare
