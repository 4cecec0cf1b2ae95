#pragma once

// Corrected ranges and range rates to a vehicle's antenna.

#include <cstddef>
#include <span>
#include <vector>

#include <wayfare/core/random.hpp>
#include <wayfare/sensors/gnss.hpp>
#include <wayfare/inertial/imu_noise.hpp>
#include <wayfare/sim/constellation.hpp>
#include <wayfare/sim/vehicle_trajectory.hpp>

namespace wayfare::sim {

/// Reflections that lengthen a range for a while: begin at random, each of constant size.
struct MultipathBursts {
  double per_satellite_hour = 0.0;  ///< how many begin; none by default
  double mean_duration_s = 10.0;
  double mean_excess_m = 20.0;  ///< duration and size are exponentially distributed
};

/// From `begin` (included) to `end` (excluded) only so many satellites are seen.
struct SatelliteOutage {
  LogTime begin, end;
  std::size_t satellites_left = 0;
};

struct RangeParams {
  Duration period = std::chrono::seconds(1);
  Angle elevation_mask = Angle::degrees(10.0);
  /// No more than so many, chosen for their geometry.
  std::size_t max_satellites = 64;
  double range_sigma_m = 2.0;
  double range_rate_sigma_mps = 0.1;
  ReceiverClockNoise clock;
  double clock_bias_m = 300.0;  ///< at the start
  double clock_drift_mps = 5.0;
  MultipathBursts multipath;
  std::vector<SatelliteOutage> outages;
  Eigen::Vector3d antenna_lever_arm_m = Eigen::Vector3d::Zero();  ///< in body axes
  /// Added to log time to give GPS time: where in their orbits the satellites are.
  Duration gps_minus_log{0};
};

struct ReceiverClock {
  double bias_m = 0.0;
  double drift_mps = 0.0;
};

struct SimulatedRanges {
  std::vector<RangeEpoch> epochs;     ///< satellites in the constellation's order
  std::vector<ReceiverClock> clocks;  ///< true, one for each epoch
};

/// One epoch every `period` from trajectory.begin() on, empty ones included. Every satellite draws
/// from its own stream of `rng`, seen or not, so that a mask or an outage leaves the noise of the
/// others and of other epochs as it was.
[[nodiscard]] SimulatedRanges simulate_ranges(const VehicleTrajectory& trajectory,
                                              const Constellation& constellation,
                                              const RangeParams& params, const Rng& rng);

/// How many satellites outages leave at `time`; the largest number where there is none.
[[nodiscard]] std::size_t satellites_allowed(std::span<const SatelliteOutage> outages,
                                             LogTime time);

/// The clock after `seconds` more: bias and drift are random walks, discretised exactly.
[[nodiscard]] ReceiverClock step_clock(const ReceiverClock& clock, const ReceiverClockNoise& noise,
                                       double seconds, Rng& rng);

/// Indices of up to `count` of the `directions` (unit vectors from the receiver), in their order:
/// one after another is taken that helps position and clock most. A smaller choice is part of every
/// larger one.
[[nodiscard]] std::vector<std::size_t> best_geometry(const std::vector<Eigen::Vector3d>& directions,
                                                     std::size_t count);

}  // namespace wayfare::sim
