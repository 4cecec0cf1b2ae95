#pragma once

// From what a receiver measured to ranges that depend on the receiver alone.

#include <array>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include <wayfare/gnss/ephemerides.hpp>
#include <wayfare/sensors/gnss.hpp>

namespace wayfare {

/// Standard deviation of a corrected range and rate. Noise and reflections grow as the signal
/// weakens, what is left of the atmosphere grows towards the horizon and with what was removed:
///   σ² = floor² + (elevation / sin el)² + (signal · 10^((45 dB-Hz − C/N0) / decade))²
///      + (fraction · ionosphere)².
/// Without C/N0 the signal term is that of 45 dB-Hz. Thermal noise alone would have a decade of
/// 20 dB; that weak signals are often reflected ones makes it less on small receivers and phones.
struct RangeSigmaModel {
  double floor_m = 0.5;      ///< orbit, clock and receiver
  double elevation_m = 0.5;  ///< troposphere and reflections, at the zenith
  double signal_m = 1.5;     ///< code noise and reflections at 45 dB-Hz
  double rate_floor_mps = 0.03;
  double rate_elevation_mps = 0.02;
  double rate_signal_mps = 0.06;  ///< at 45 dB-Hz
  double decade_dbhz = 16.0;      ///< so much less C/N0 is ten times the noise
  /// Of the ionosphere's delay this part is still unknown: with a broadcast model, and with the
  /// nominal one.
  double ionosphere_fraction = 0.3, nominal_ionosphere_fraction = 0.5;
  double scale = 1.0;  ///< multiplies both
  [[nodiscard]] double range_m(double elevation_rad, double cn0_dbhz,
                               double unknown_ionosphere_m = 0.0) const;
  [[nodiscard]] double rate_mps(double elevation_rad, double cn0_dbhz) const;
};

/// A quiet sun's model for messages without coefficients: 7.5 m at the zenith in the afternoon,
/// 1.5 m at night.
[[nodiscard]] KlobucharModel nominal_ionosphere();

struct RangeCorrectionOptions {
  /// Which systems to use: GPS, GLONASS, Galileo, BeiDou.
  std::array<bool, kGnssSystems> systems = {true, true, true, true};
  std::vector<SatelliteId> excluded;
  /// Satellites lower than this are left out; multipath and the atmosphere spoil them.
  Angle elevation_mask = Angle::degrees(10.0);
  /// Signals weaker than this are left out, dB-Hz; ranges without C/N0 are kept.
  double min_cn0_dbhz = 0.0;
  /// Klobuchar's model with the coefficients of the messages, or nominal ones where they have none.
  bool ionosphere = true;
  /// Saastamoinen's model.
  bool troposphere = true;
  double relative_humidity = 0.7;
  RangeSigmaModel sigma;
  EphemerisLimits limits;
};

/// Why a satellite of an epoch is not among the ranges.
enum class RangeRefusal : std::uint8_t {
  not_measured,       ///< neither a range nor a rate
  absurd,             ///< a range no satellite can have
  not_wanted,         ///< its system or itself is switched off
  duplicate,          ///< the satellite came earlier in the epoch
  no_ephemeris,       ///< no message of it at all
  ephemeris_too_far,  ///< the nearest message is beyond the age limit
  unhealthy,
  unknown_signal,  ///< no group delay is known for its carrier
  low,             ///< below the elevation mask
  weak,            ///< below the least C/N0
};
[[nodiscard]] const char* to_text(RangeRefusal why);

struct RefusedRange {
  SatelliteId satellite;
  RangeRefusal why = RangeRefusal::not_measured;
};

/// Corrects one epoch. `near_ecef_m` is about where the receiver is: it decides the elevation, the
/// atmosphere and the last centimetres of Sagnac's effect (6 mm for each km it is off). Where it is
/// nearer than 1000 km to the Earth's centre it counts as unknown: then there is no atmosphere and
/// no elevation mask. A satellite with a rate but no range is kept with a NaN range, and the other
/// way round. The clock of the result is GPS time (`log_time`). `refused` takes the others.
[[nodiscard]] RangeEpoch correct_ranges(const ObservationEpoch& epoch,
                                        const Ephemerides& ephemerides,
                                        const Eigen::Vector3d& near_ecef_m,
                                        const RangeCorrectionOptions& options = {},
                                        std::vector<RefusedRange>* refused = nullptr);

}  // namespace wayfare
