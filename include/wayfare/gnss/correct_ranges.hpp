#pragma once

// Corrects measured pseudoranges and Dopplers for satellite clock, group delay and atmosphere.

#include <array>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include <wayfare/gnss/ephemerides.hpp>
#include <wayfare/sensors/measurements.hpp>

namespace wayfare {

/// Standard deviation of a corrected range and rate. Noise and multipath grow with decreasing C/N0,
/// atmospheric residuals with decreasing elevation and with the correction:
///   σ² = floor² + (elevation / sin el)² + (signal · 10^((45 dB-Hz − C/N0) / decade))²
///      + (fraction · ionosphere)².
/// Without C/N0 the signal term is that of 45 dB-Hz. Thermal noise alone has a decade of 20 dB; it
/// is less on small receivers and phones, where weak signals are often multipath.
struct RangeSigmaModel {
  double floor_m = 0.5;              ///< orbit, clock and receiver
  double elevation_m = 0.5;          ///< troposphere and multipath, at the zenith
  double signal_m = 1.5;             ///< code noise and multipath at 45 dB-Hz
  double rate_floor_mps = 0.03;      ///< m/s, orbit, clock and receiver
  double rate_elevation_mps = 0.02;  ///< m/s, at the zenith
  double rate_signal_mps = 0.06;     ///< noise of the rate at 45 dB-Hz
  double phase_floor_m = 0.003;      ///< noise of a carrier phase
  double phase_elevation_m = 0.003;  ///< multipath of a carrier phase, at the zenith
  double decade_dbhz = 16.0;         ///< decrease of C/N0 for ten times the noise
  /// Residual fraction of the ionospheric delay: with a broadcast model, and with the nominal one.
  double ionosphere_fraction = 0.3,       ///< with a broadcast model
      nominal_ionosphere_fraction = 0.5;  ///< with the nominal one
  double scale = 1.0;                     ///< multiplies both
  /// σ of a range, m; `unknown_ionosphere_m`: the delay times its residual fraction.
  [[nodiscard]] double range_m(double elevation_rad, double cn0_dbhz,
                               double unknown_ionosphere_m = 0.0) const;
  /// σ of a range rate, m/s.
  [[nodiscard]] double rate_mps(double elevation_rad, double cn0_dbhz) const;
  /// σ of a carrier phase, for differences over seconds: √(floor² + (elevation / sin el)²), m.
  [[nodiscard]] double phase_m(double elevation_rad) const;
};

/// Model at low solar activity for messages without coefficients: 7.5 m at the zenith in the
/// afternoon, 1.5 m at night.
[[nodiscard]] KlobucharModel nominal_ionosphere();

/// Satellites, models and sigmas of correct_ranges.
struct RangeCorrectionOptions {
  /// Which systems to use: GPS, GLONASS, Galileo, BeiDou.
  std::array<bool, kGnssSystems> systems = {true, true, true, true};
  std::vector<SatelliteId> excluded;  ///< not used at all
  /// Satellites below this elevation are excluded because of multipath and atmosphere.
  Angle elevation_mask = Angle::degrees(10.0);
  /// Weaker signals are excluded, dB-Hz; ranges without C/N0 are kept.
  double min_cn0_dbhz = 0.0;
  /// Klobuchar's model with the broadcast coefficients, or nominal ones if there are none.
  bool ionosphere = true;
  /// Saastamoinen's model.
  bool troposphere = true;
  double relative_humidity = 0.7;  ///< of Saastamoinen's model, 0 to 1
  RangeSigmaModel sigma;           ///< of the corrected ranges and rates
  EphemerisLimits limits;          ///< largest age of a message
};

/// Why a satellite of an epoch was rejected.
enum class RangeRefusal : std::uint8_t {
  not_measured,       ///< neither a range nor a rate
  implausible,        ///< a range no satellite can have
  not_wanted,         ///< excluded by the options
  duplicate,          ///< repeated within the epoch
  no_ephemeris,       ///< no message of this satellite
  ephemeris_too_far,  ///< the nearest message is beyond the age limit
  unhealthy,          ///< by the message
  unknown_signal,     ///< no group delay is known for its carrier
  low,                ///< below the elevation mask
  weak,               ///< below the minimum C/N0
};
/// In words, for reports.
[[nodiscard]] const char* to_text(RangeRefusal why);

/// A satellite of an epoch that was not used.
struct RefusedRange {
  SatelliteId satellite;                          ///< rejected
  RangeRefusal why = RangeRefusal::not_measured;  ///< first reason found
};

/// Corrects one epoch. `near_ecef_m` is the approximate receiver position, for elevation,
/// atmosphere and Sagnac effect (6 mm per km of error). Within 1000 km of the Earth's centre, or
/// beyond 10⁹ m of it, it counts as unknown: no atmosphere and no elevation mask are applied. A
/// satellite with a rate but no range is kept with a NaN range, and vice versa. The result is in
/// GPS time (`log_time`). Rejected satellites are appended to `refused`.
[[nodiscard]] RangeEpoch correct_ranges(const ObservationEpoch& epoch,
                                        const Ephemerides& ephemerides,
                                        const Eigen::Vector3d& near_ecef_m,
                                        const RangeCorrectionOptions& options = {},
                                        std::vector<RefusedRange>* refused = nullptr);

}  // namespace wayfare
