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
  LogTime time;
  Eigen::Vector3d angular_rate_radps = Eigen::Vector3d::Zero();
  Eigen::Vector3d specific_force_mps2 = Eigen::Vector3d::Zero();
};

/// One instant of a nine-axis unit (magnetic, angular rate, gravity) in its own axes. A missing
/// measurement is NaN.
struct MargSample {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

  LogTime time;
  Eigen::Vector3d angular_rate_radps = Eigen::Vector3d::Constant(kNone);
  /// What accelerometers measure: +g upward at rest.
  Eigen::Vector3d specific_force_mps2 = Eigen::Vector3d::Constant(kNone);
  Eigen::Vector3d magnetic_field_uT = Eigen::Vector3d::Constant(kNone);
};

using MargRecording = std::vector<MargSample>;

/// Distance rolled by each of two driven wheels since the previous sample, metres.
struct WheelSample {
  LogTime time;
  double left_m = 0.0;
  double right_m = 0.0;
};

/// The mean turn rate since the previous sample, counter-clockwise positive.
struct GyroSample {
  LogTime time;
  double turn_rate_rad_s = 0.0;
};

enum class GnssSystem : std::uint8_t { gps, glonass, galileo, beidou };
inline constexpr int kGnssSystems = 4;

/// A satellite by system and number (PRN; the slot for GLONASS), from 1.
struct SatelliteId {
  GnssSystem system = GnssSystem::gps;
  std::uint8_t number = 0;
  auto operator<=>(const SatelliteId&) const = default;
};

/// One satellite's raw code and Doppler measurement on one signal. NaN: not measured.
struct SatelliteObservation {
  SatelliteId satellite;
  double pseudorange_m = std::numeric_limits<double>::quiet_NaN();
  double doppler_hz = std::numeric_limits<double>::quiet_NaN();  ///< positive when approaching
  double carrier_cycles = std::numeric_limits<double>::quiet_NaN();
  double cn0_dbhz = std::numeric_limits<double>::quiet_NaN();
  double carrier_hz = std::numeric_limits<double>::quiet_NaN();  ///< the signal's frequency
};

/// All satellites of one reception time on the receiver's clock.
struct ObservationEpoch {
  Time<GpsClock> time;
  std::vector<SatelliteObservation> satellites;
};

/// A range and range rate without satellite clock, relativity, group delay and atmosphere:
///   range = |p − satellite position| + clock bias + noise,
///   rate  = uᵀ(satellite velocity − v) + clock drift + noise, u from receiver to satellite.
/// The satellite is where it was at transmission, in the Earth-fixed axes of the time of reception
/// (so its position and velocity include the Sagnac effect). NaN: not measured.
struct CorrectedRange {
  SatelliteId satellite;
  Eigen::Vector3d position_ecef_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_ecef_mps = Eigen::Vector3d::Zero();
  double range_m = std::numeric_limits<double>::quiet_NaN();
  double range_rate_mps = std::numeric_limits<double>::quiet_NaN();
  double range_sigma_m = 1.0;
  double range_rate_sigma_mps = 0.1;
  double cn0_dbhz = std::numeric_limits<double>::quiet_NaN();
};

struct RangeEpoch {
  LogTime time;
  std::vector<CorrectedRange> satellites;
};

/// A receiver's own position, and velocity where it reports one.
struct GnssFix {
  LogTime time;
  Geodetic position;
  Eigen::Matrix3d position_covariance_ned_m2 = Eigen::Matrix3d::Identity();
  std::optional<Eigen::Vector3d> velocity_ned_mps;
  Eigen::Matrix3d velocity_covariance_ned = Eigen::Matrix3d::Identity();  ///< (m/s)²
};

}  // namespace wayfare
