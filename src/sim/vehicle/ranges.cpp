#include <wayfare/sim/gnss.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>
#include <variant>

#include <Eigen/Cholesky>

#include <wayfare/gnss/correct_ranges.hpp>
#include <wayfare/gnss/ephemerides.hpp>
#include <wayfare/gnss/gps_time.hpp>

#include "sim/vehicle/satellite_noise.hpp"

namespace wayfare::sim {
namespace {

enum RangeStream : std::uint64_t { kClock, kFirstSatellite };

/// Phases of satellites that were not measured in the epoch before have another ambiguity.
template <class Epoch>
void interrupt_new(const std::vector<Epoch>& before, Epoch& epoch) {
  for (auto& s : epoch.satellites) {
    const auto same = [&](const auto& other) { return other.satellite == s.satellite; };
    if (before.empty() ||
        std::none_of(before.back().satellites.begin(), before.back().satellites.end(), same))
      s.phase_interrupted = true;
  }
}

CorrectedRange true_range(SatelliteId id, const SatelliteMotion& satellite,
                          const EcefMotion& antenna, const RangeParams& params) {
  const Eigen::Vector3d line = satellite.position_ecef_m - antenna.position_m;
  CorrectedRange r;
  r.satellite = id;
  r.position_ecef_m = satellite.position_ecef_m;
  r.velocity_ecef_mps = satellite.velocity_ecef_mps;
  r.range_m = line.norm();
  r.range_rate_mps = line.normalized().dot(satellite.velocity_ecef_mps - antenna.velocity_mps);
  r.range_sigma_m = params.range_sigma_m;
  r.range_rate_sigma_mps = params.range_rate_sigma_mps;
  return r;
}

double first_carrier_hz(const Ephemeris& message) {
  if (const auto* glonass = std::get_if<GlonassEphemeris>(&message))
    return carrier::kGlonassL1 + glonass->channel * carrier::kGlonassL1Step;
  return satellite_of(message).system == GnssSystem::beidou ? carrier::kB1I : carrier::kL1;
}

/// Delays of the code; the ionosphere advances the phase by as much.
struct AirDelay {
  double troposphere_m = 0.0, ionosphere_m = 0.0;
};

AirDelay air_delay(const ObservationParams& params, const Ephemerides& ephemerides,
                   Time<GpsClock> time, const Geodetic& place, const LineOfSight& sight,
                   double carrier_hz) {
  AirDelay delay{params.troposphere ? troposphere_delay_m(place, sight) : 0.0, 0.0};
  if (!params.ionosphere) return delay;
  const auto& broadcast =
      ephemerides.gps_ionosphere ? ephemerides.gps_ionosphere : ephemerides.beidou_ionosphere;
  delay.ionosphere_m = ionosphere_delay_m(broadcast ? *broadcast : nominal_ionosphere(), time,
                                          place, sight, carrier_hz);
  return delay;
}

// The receiver at an epoch: true position, time, and its clock's reading.
struct Receiver {
  EcefMotion antenna;
  Geodetic place;
  Time<GpsClock> instant;
  ReceiverClock clock;
};

SatelliteObservation observe(const Receiver& receiver, const Ephemeris& message,
                             const SatelliteMotion& satellite, const AirDelay& air) {
  const Eigen::Vector3d line = satellite.position_ecef_m - receiver.antenna.position_m;
  const Eigen::Vector3d u = line.normalized();
  const double c = kSpeedOfLight_mps;
  SatelliteObservation o;
  o.satellite = satellite_of(message);
  o.carrier_hz = first_carrier_hz(message);
  const double delay_s = group_delay_s(message, o.carrier_hz).value_or(0.0);
  o.pseudorange_m = line.norm() + receiver.clock.bias_m - c * (satellite.clock_bias_s - delay_s) +
                    (air.troposphere_m + air.ionosphere_m);
  // The derivative of the range with respect to the time of reception: the travel time changes too,
  // and the axes of reception rotate meanwhile.
  const double stretch = u.dot(satellite.velocity_ecef_mps) / c;
  const Eigen::Vector3d& p = satellite.position_ecef_m;
  const Eigen::Vector3d seen =
      (1.0 - stretch) * satellite.velocity_ecef_mps +
      stretch * wgs84::kEarthRate_radps * Eigen::Vector3d(p.y(), -p.x(), 0.0);
  const double rate = u.dot(seen - receiver.antenna.velocity_mps) + receiver.clock.drift_mps -
                      c * satellite.clock_drift;
  o.doppler_hz = -rate * o.carrier_hz / c;
  return o;
}

/// Carrier phase without noise and ambiguity.
double carrier_m(const Receiver& receiver, const SatelliteMotion& satellite, const AirDelay& air) {
  return (satellite.position_ecef_m - receiver.antenna.position_m).norm() + receiver.clock.bias_m -
         kSpeedOfLight_mps * satellite.clock_bias_s + air.troposphere_m - air.ionosphere_m;
}

}  // namespace

std::size_t satellites_allowed(std::span<const SatelliteOutage> outages, LogTime time) {
  std::size_t allowed = std::numeric_limits<std::size_t>::max();
  for (const SatelliteOutage& o : outages)
    if (time >= o.begin && time < o.end) allowed = std::min(allowed, o.satellites_left);
  return allowed;
}

ReceiverClock step_clock(const ReceiverClock& clock, const ReceiverClockNoise& noise,
                         double seconds, Rng& rng) {
  const double walk = noise.drift_walk_mps_per_sqrt_s * std::sqrt(seconds) * rng.normal();
  // The integral of a random walk, given its end: half the end, and a spread of T³/12.
  const double bridge =
      noise.drift_walk_mps_per_sqrt_s * std::sqrt(std::pow(seconds, 3) / 12.0) * rng.normal();
  const double jitter = noise.bias_walk_m_per_sqrt_s * std::sqrt(seconds) * rng.normal();
  return {clock.bias_m + seconds * (clock.drift_mps + 0.5 * walk) + bridge + jitter,
          clock.drift_mps + walk};
}

std::vector<std::size_t> best_geometry(const std::vector<Eigen::Vector3d>& directions,
                                       std::size_t count) {
  std::vector<std::size_t> left(directions.size()), taken;
  for (std::size_t i = 0; i < left.size(); ++i) left[i] = i;
  const auto row = [&](std::size_t i) {
    return Eigen::Vector4d(directions[i].x(), directions[i].y(), directions[i].z(), 1.0);
  };
  Eigen::Matrix4d information = 1e-3 * Eigen::Matrix4d::Identity();
  while (taken.size() < count && !left.empty()) {
    const auto uncertainty_with = [&](std::size_t i) {
      const Eigen::Matrix4d with = information + row(i) * row(i).transpose();
      return Eigen::Matrix4d(with.ldlt().solve(Eigen::Matrix4d::Identity())).trace();
    };
    std::size_t best = 0;
    double least = uncertainty_with(left[0]);
    for (std::size_t k = 1; k < left.size(); ++k) {
      const double trace = uncertainty_with(left[k]);
      if (trace < least) least = trace, best = k;
    }
    information += row(left[best]) * row(left[best]).transpose();
    taken.push_back(left[best]);
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(best));
  }
  std::sort(taken.begin(), taken.end());
  return taken;
}

SimulatedRanges simulate_ranges(const VehicleTrajectory& trajectory,
                                const Constellation& constellation, const RangeParams& params,
                                const Rng& rng) {
  WAYFARE_EXPECTS(params.period > Duration::zero(), "a receiver needs a positive period");
  WAYFARE_EXPECTS(params.correlated_share >= 0.0 && params.correlated_share <= 1.0 &&
                      params.correlated_tau_s > 0.0,
                  "a share within [0, 1] of a range's variance, correlated over a positive time");
  const double dt = to_seconds(params.period);
  const double slow_m = params.range_sigma_m * std::sqrt(params.correlated_share);
  const double white_m = params.correlated_share == 0.0
                             ? params.range_sigma_m
                             : params.range_sigma_m * std::sqrt(1.0 - params.correlated_share);
  Rng clock_noise = rng.stream(kClock);
  std::vector<SatelliteNoise> noises =
      satellite_noises(rng, kFirstSatellite, constellation.satellites.size());

  SimulatedRanges result;
  ReceiverClock clock{params.clock_bias_m, params.clock_drift_mps};
  for (LogTime t = trajectory.begin(); t <= trajectory.end(); t += params.period) {
    if (!result.clocks.empty()) clock = step_clock(clock, params.clock, dt, clock_noise);
    const VehicleMotion vehicle = trajectory.motion(t);
    const EcefMotion antenna = ecef_motion(vehicle, params.antenna_lever_arm_m);
    const Geodetic place = geodetic_from_ecef(antenna.position_m);
    const auto gps = Time<GpsClock>::from_nanoseconds((t + params.gps_minus_log).nanoseconds());
    std::vector<CorrectedRange> seen;
    std::vector<Eigen::Vector3d> directions;
    for (std::size_t i = 0; i < noises.size(); ++i) {
      noises[i].step(white_m, params.range_rate_sigma_mps, params.multipath, dt);
      if (params.correlated_share > 0.0)
        noises[i].range_m += slow_m * noises[i].step_correlated(params.correlated_tau_s, dt);
      const SatelliteId id = constellation.satellites[i];
      const auto satellite = seen_from(constellation, id, gps, antenna.position_m);
      if (!satellite || elevation(place, satellite->position_ecef_m) < params.elevation_mask)
        continue;
      CorrectedRange range = true_range(id, *satellite, antenna, params);
      if (params.phases) {
        noises[i].step_phase(*params.phases, dt);
        range.phase_m = range.range_m + clock.bias_m + noises[i].phase_m +
                        noises[i].cycles * kSpeedOfLight_mps / carrier::kL1;
        range.phase_sigma_m = params.phases->sigma_m;
        range.phase_interrupted = noises[i].interrupted;
      }
      range.range_m += clock.bias_m + noises[i].range_m;
      range.range_rate_mps += clock.drift_mps + noises[i].rate_mps;
      directions.push_back((range.position_ecef_m - antenna.position_m).normalized());
      seen.push_back(range);
    }
    RangeEpoch epoch{t, {}};
    for (const std::size_t i : best_geometry(
             directions, std::min(params.max_satellites, satellites_allowed(params.outages, t))))
      epoch.satellites.push_back(seen[i]);
    if (params.phases) interrupt_new(result.epochs, epoch);
    result.epochs.push_back(std::move(epoch));
    result.clocks.push_back(clock);
  }
  return result;
}

Constellation broadcast_constellation(const Ephemerides& ephemerides) {
  Constellation c;
  c.satellites = ephemerides.satellites();
  c.motion = [&ephemerides](SatelliteId id, Time<GpsClock> t) -> std::optional<SatelliteMotion> {
    const Ephemeris* message = ephemerides.nearest(id, t);
    if (message == nullptr) return std::nullopt;
    const SatelliteState s = satellite_state(*message, t);
    return SatelliteMotion{s.position_ecef_m, s.velocity_ecef_mps, s.clock_s, s.clock_drift};
  };
  return c;
}

Ephemerides walker_ephemerides(const WalkerParams& params, Time<GpsClock> reference) {
  WAYFARE_EXPECTS(params.planes > 0 && params.satellites >= params.planes &&
                      params.satellites % params.planes == 0 && params.satellites < 256,
                  "every plane has the same number of satellites");
  const int per_plane = params.satellites / params.planes;
  Ephemerides messages;
  for (int i = 0; i < params.satellites; ++i) {
    const int plane = i / per_plane, slot = i % per_plane;
    const auto turn = [](double part) { return wrap_to_pi(2.0 * std::numbers::pi * part); };
    KeplerianEphemeris e;
    e.satellite = {params.system, static_cast<std::uint8_t>(i + 1)};
    e.toe = e.toc = reference;
    e.sqrt_semi_major_axis = std::sqrt(params.radius_m);
    e.eccentricity = 0.001 * (1 + i % 8);
    e.inclination_rad = params.inclination.radians();
    e.ascending_node_rad =
        wrap_to_pi(params.first_node.radians() + turn(double(plane) / params.planes));
    e.ascending_node_rate_radps = -8e-9;
    e.mean_anomaly_rad =
        turn(double(slot) / per_plane + double(params.phasing * plane) / params.satellites);
    e.clock_bias_s = 1e-5 * (i % 21 - 10);
    e.clock_drift = 1e-12 * (i % 7 - 3);
    e.group_delay_s[0] = 1e-9 * (i % 11 - 5);
    (void)messages.add(e);
  }
  return messages;
}

SimulatedObservations simulate_observations(const VehicleTrajectory& trajectory,
                                            const Ephemerides& ephemerides,
                                            const ObservationParams& params, const Rng& rng) {
  WAYFARE_EXPECTS(params.period > Duration::zero(), "a receiver needs a positive period");
  const Constellation sky = broadcast_constellation(ephemerides);
  const double dt = to_seconds(params.period);
  Rng clock_noise = rng.stream(kClock);
  std::vector<SatelliteNoise> noises =
      satellite_noises(rng, kFirstSatellite, sky.satellites.size());

  SimulatedObservations result;
  Receiver r;
  r.clock = {params.clock_bias_m, params.clock_drift_mps};
  for (LogTime t = trajectory.begin(); t <= trajectory.end(); t += params.period) {
    if (!result.clocks.empty()) r.clock = step_clock(r.clock, params.clock, dt, clock_noise);
    const LogTime true_time = t - from_seconds(r.clock.bias_m / kSpeedOfLight_mps);
    r.antenna = ecef_motion(trajectory.motion(true_time), params.antenna_lever_arm_m);
    r.place = geodetic_from_ecef(r.antenna.position_m);
    r.instant = gps_time(true_time);
    ObservationEpoch epoch{gps_time(t), {}};
    std::vector<Eigen::Vector3d> directions;
    for (std::size_t i = 0; i < noises.size(); ++i) {
      const Ephemeris* message = ephemerides.nearest(sky.satellites[i], r.instant);
      const double wavelength = kSpeedOfLight_mps / first_carrier_hz(*message);
      noises[i].step(params.code_sigma_m, params.doppler_sigma_hz * wavelength, params.multipath,
                     dt);
      const auto satellite = seen_from(sky, sky.satellites[i], r.instant, r.antenna.position_m);
      if (!satellite) continue;
      const LineOfSight sight = line_of_sight(r.place, satellite->position_ecef_m);
      if (sight.elevation_rad < params.elevation_mask.radians()) continue;
      const AirDelay air =
          air_delay(params, ephemerides, epoch.time, r.place, sight, first_carrier_hz(*message));
      SatelliteObservation o = observe(r, *message, *satellite, air);
      if (params.phases) {
        noises[i].step_phase(*params.phases, dt);
        o.carrier_cycles =
            (carrier_m(r, *satellite, air) + noises[i].phase_m) / wavelength + noises[i].cycles;
        o.phase_interrupted = noises[i].interrupted;
      }
      o.pseudorange_m += noises[i].range_m;
      o.doppler_hz -= noises[i].rate_mps / wavelength;
      o.cn0_dbhz = params.cn0_horizon_dbhz + (params.cn0_zenith_dbhz - params.cn0_horizon_dbhz) *
                                                 std::sin(sight.elevation_rad);
      directions.push_back((satellite->position_ecef_m - r.antenna.position_m).normalized());
      epoch.satellites.push_back(o);
    }
    ObservationEpoch chosen{epoch.time, {}};
    const std::size_t allowed = satellites_allowed(params.outages, t);
    for (const std::size_t i : best_geometry(directions, std::min(directions.size(), allowed)))
      chosen.satellites.push_back(epoch.satellites[i]);
    if (params.phases) interrupt_new(result.epochs, chosen);
    result.epochs.push_back(std::move(chosen));
    result.clocks.push_back(r.clock);
  }
  return result;
}

}  // namespace wayfare::sim
