#pragma once

// Satellite constellations, corrected ranges and range rates to a vehicle's antenna, and the raw
// code and Doppler measurements that a receiver logs: with broadcast messages, satellite clocks,
// group delay, atmosphere and the receiver's own clock.

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/random.hpp>
#include <wayfare/gnss/ephemerides.hpp>
#include <wayfare/inertial/imu_noise.hpp>
#include <wayfare/sensors/measurements.hpp>
#include <wayfare/sim/vehicle_trajectory.hpp>

namespace wayfare::sim {

/// A satellite at one instant, in the Earth-fixed axes of that instant.
struct SatelliteMotion {
  Eigen::Vector3d position_ecef_m = Eigen::Vector3d::Zero();    ///< m
  Eigen::Vector3d velocity_ecef_mps = Eigen::Vector3d::Zero();  ///< m/s
  double clock_bias_s = 0.0;                                    ///< advance of its clock
  double clock_drift = 0.0;                                     ///< s/s
};

/// Satellites and their motion; nothing for one that is unknown at that time.
struct Constellation {
  std::vector<SatelliteId> satellites;  ///< in the order of simulations
  std::function<std::optional<SatelliteMotion>(SatelliteId, Time<GpsClock>)> motion;  ///< at a time
};

/// Evenly spread circular orbits: `planes` of equal inclination, equally spaced nodes (Walker
/// 1984).
struct WalkerParams {
  GnssSystem system = GnssSystem::gps;       ///< of the satellites
  int satellites = 24;                       ///< in all planes; a multiple of `planes`, at most 255
  int planes = 6;                            ///< number
  int phasing = 1;                           ///< between neighbouring planes, in 360°/satellites
  double radius_m = 26'559'710.0;            ///< of the orbits, from the Earth's centre
  Angle inclination = Angle::degrees(55.0);  ///< of the planes to the equator
  Angle first_node = Angle::degrees(17.0);   ///< east of Greenwich at GPS time zero
};

/// Requires as many satellites in every plane, at least one, and at most 255 in all.
[[nodiscard]] Constellation walker_constellation(const WalkerParams& params = {});
/// The satellites of both, which must be distinct.
[[nodiscard]] Constellation combined(Constellation a, Constellation b);
/// GPS (24 satellites in 6 planes) and Galileo (24 in 3): about 8 and 8 above 10°.
[[nodiscard]] Constellation gps_and_galileo();

/// The satellite for a range measured at `reception`: its position at transmission, in the
/// Earth-fixed axes of reception. Nothing for one that is unknown then, or where its position or
/// the receiver's is not finite.
[[nodiscard]] std::optional<SatelliteMotion> seen_from(const Constellation& constellation,
                                                       SatelliteId satellite,
                                                       Time<GpsClock> reception,
                                                       const Eigen::Vector3d& receiver_ecef_m);

/// Above the receiver's horizon.
[[nodiscard]] Angle elevation(const Geodetic& receiver, const Eigen::Vector3d& satellite_ecef_m);

/// Reflections that lengthen a range for a while: random onsets, each of constant size.
struct MultipathBursts {
  double per_satellite_hour = 0.0;  ///< rate of onsets; none by default
  double mean_duration_s = 10.0;    ///< of a burst
  double mean_excess_m = 20.0;      ///< duration and size are exponentially distributed
};

/// Carrier phases: white noise, ambiguities, and cycle slips of 1 to 20 cycles to either side.
struct PhaseParams {
  double sigma_m = 0.003;                 ///< standard deviation of a phase
  double slips_per_satellite_hour = 0.0;  ///< rate of slips
  double announced = 0.5;                 ///< fraction of slips that the receiver notices
};

/// From `begin` (included) to `end` (excluded) only this number of satellites is visible.
struct SatelliteOutage {
  LogTime begin,                    ///< included
      end;                          ///< excluded
  std::size_t satellites_left = 0;  ///< visible
};

/// A receiver, whatever it measures.
struct ReceiverParams {
  Duration period = std::chrono::seconds(1);    ///< between epochs
  Angle elevation_mask = Angle::degrees(10.0);  ///< lower satellites are not measured
  ReceiverClockNoise clock;                     ///< random walks of the receiver clock
  double clock_bias_m = 300.0;                  ///< at the start
  double clock_drift_mps = 5.0;                 ///< at the start
  MultipathBursts multipath;                    ///< of every satellite
  std::optional<PhaseParams> phases;            ///< absent: no phases
  std::vector<SatelliteOutage> outages;         ///< of satellites
  Eigen::Vector3d antenna_lever_arm_m = Eigen::Vector3d::Zero();  ///< in body axes
};

/// A receiver of corrected ranges.
struct RangeParams : ReceiverParams {
  /// Upper limit; the best geometry is selected.
  std::size_t max_satellites = 64;
  double range_sigma_m = 2.0;         ///< standard deviation
  double range_rate_sigma_mps = 0.1;  ///< standard deviation
  /// Of the variance of a range: an error of each satellite with this correlation time, in place of
  /// white noise.
  double correlated_share = 0.0,  ///< [0, 1]
      correlated_tau_s = 100.0;   ///< s
  /// Added to log time to give GPS time, which determines the satellites' positions.
  Duration gps_minus_log{0};
};

/// Error of the receiver clock, times the speed of light.
struct ReceiverClock {
  double bias_m = 0.0;     ///< advance
  double drift_mps = 0.0;  ///< its rate
};

/// Ranges of a drive and the truth behind them.
struct SimulatedRanges {
  std::vector<RangeEpoch> epochs;     ///< satellites in the constellation's order
  std::vector<ReceiverClock> clocks;  ///< true, one per epoch
};

/// One epoch every `period` from trajectory.begin() on, empty ones included. Every satellite draws
/// from its own stream of `rng`, visible or not, so that a mask or an outage does not change the
/// noise of the others and of other epochs.
[[nodiscard]] SimulatedRanges simulate_ranges(const VehicleTrajectory& trajectory,
                                              const Constellation& constellation,
                                              const RangeParams& params, const Rng& rng);

/// Number of satellites that outages leave at `time`; the largest number without one.
[[nodiscard]] std::size_t satellites_allowed(std::span<const SatelliteOutage> outages,
                                             LogTime time);

/// The clock after `seconds`: bias and drift are random walks, discretised exactly.
[[nodiscard]] ReceiverClock step_clock(const ReceiverClock& clock, const ReceiverClockNoise& noise,
                                       double seconds, Rng& rng);

/// Indices of up to `count` of the `directions` (unit vectors from the receiver), in their order,
/// selected greedily by their benefit for position and clock. A smaller selection is a subset of
/// every larger one.
[[nodiscard]] std::vector<std::size_t> best_geometry(const std::vector<Eigen::Vector3d>& directions,
                                                     std::size_t count);

/// Satellite positions from the messages nearest in time, unhealthy ones included. `ephemerides`
/// must outlive it.
[[nodiscard]] Constellation broadcast_constellation(const Ephemerides& ephemerides);

/// Messages of satellites on nearly circular orbits in a Walker constellation, for use without a
/// navigation file. Clocks differ by up to a tenth of a millisecond.
[[nodiscard]] Ephemerides walker_ephemerides(const WalkerParams& params, Time<GpsClock> reference);

/// A receiver of raw code and Doppler measurements.
struct ObservationParams : ReceiverParams {
  double code_sigma_m = 0.6;       ///< standard deviation of the code
  double doppler_sigma_hz = 0.3;   ///< standard deviation
  bool ionosphere = true;          ///< Klobuchar's, with the messages' coefficients if present
  bool troposphere = true;         ///< Saastamoinen's
  double cn0_zenith_dbhz = 48.0;   ///< of a satellite at the zenith
  double cn0_horizon_dbhz = 35.0;  ///< of one at the horizon
};

/// Observations of a drive and the truth behind them.
struct SimulatedObservations {
  std::vector<ObservationEpoch> epochs;  ///< in order of time
  std::vector<ReceiverClock> clocks;     ///< true, one for each epoch
};

/// One epoch every `period` of the receiver's own clock. The trajectory's times are GPS time. Each
/// satellite is measured on its first carrier (L1, E1, B1I, G1) and draws from its own stream.
[[nodiscard]] SimulatedObservations simulate_observations(const VehicleTrajectory& trajectory,
                                                          const Ephemerides& ephemerides,
                                                          const ObservationParams& params,
                                                          const Rng& rng);

}  // namespace wayfare::sim
