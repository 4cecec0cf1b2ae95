#pragma once

// Raw code and Doppler measurements as logged by a receiver, from broadcast messages: with
// satellite clocks, group delay, atmosphere and the receiver's own clock.

#include <vector>

#include <wayfare/gnss/ephemerides.hpp>
#include <wayfare/sim/ranges.hpp>

namespace wayfare::sim {

/// Satellite positions from the messages nearest in time, unhealthy ones included. `ephemerides`
/// must outlive it.
[[nodiscard]] Constellation broadcast_constellation(const Ephemerides& ephemerides);

/// Messages of satellites on nearly circular orbits in a Walker constellation, for use without a
/// navigation file. Clocks differ by up to a tenth of a millisecond.
[[nodiscard]] Ephemerides walker_ephemerides(const WalkerParams& params, Time<GpsClock> reference);

struct ObservationParams {
  Duration period = std::chrono::seconds(1);
  Angle elevation_mask = Angle::degrees(10.0);
  double code_sigma_m = 0.6;
  double doppler_sigma_hz = 0.3;
  ReceiverClockNoise clock;
  double clock_bias_m = 300.0;  ///< at the start
  double clock_drift_mps = 5.0;
  bool ionosphere = true;   ///< Klobuchar's, with the messages' coefficients if present
  bool troposphere = true;  ///< Saastamoinen's
  double cn0_zenith_dbhz = 48.0;
  double cn0_horizon_dbhz = 35.0;
  MultipathBursts multipath;
  std::vector<SatelliteOutage> outages;
  Eigen::Vector3d antenna_lever_arm_m = Eigen::Vector3d::Zero();  ///< in body axes
};

struct SimulatedObservations {
  std::vector<ObservationEpoch> epochs;
  std::vector<ReceiverClock> clocks;  ///< true, one for each epoch
};

/// One epoch every `period` of the receiver's own clock. The trajectory's times are GPS time. Each
/// satellite is measured on its first carrier (L1, E1, B1I, G1) and draws from its own stream.
[[nodiscard]] SimulatedObservations simulate_observations(const VehicleTrajectory& trajectory,
                                                          const Ephemerides& ephemerides,
                                                          const ObservationParams& params,
                                                          const Rng& rng);

}  // namespace wayfare::sim
