#include <wayfare/sim/gnss.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>

#include "sim/vehicle/satellite_noise.hpp"

namespace wayfare::sim {
namespace {

enum Stream : std::uint64_t { kClock, kFirstSatellite };

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
  const double dt = to_seconds(params.period);
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
      noises[i].step(params.range_sigma_m, params.range_rate_sigma_mps, params.multipath, dt);
      const SatelliteId id = constellation.satellites[i];
      const auto satellite = seen_from(constellation, id, gps, antenna.position_m);
      if (!satellite || elevation(place, satellite->position_ecef_m) < params.elevation_mask)
        continue;
      CorrectedRange range = true_range(id, *satellite, antenna, params);
      range.range_m += clock.bias_m + noises[i].range_m;
      range.range_rate_mps += clock.drift_mps + noises[i].rate_mps;
      directions.push_back((range.position_ecef_m - antenna.position_m).normalized());
      seen.push_back(range);
    }
    RangeEpoch epoch{t, {}};
    for (const std::size_t i : best_geometry(
             directions, std::min(params.max_satellites, satellites_allowed(params.outages, t))))
      epoch.satellites.push_back(seen[i]);
    result.epochs.push_back(std::move(epoch));
    result.clocks.push_back(clock);
  }
  return result;
}

}  // namespace wayfare::sim
