#pragma once

// A drive with exact inertial readings, and ranges to stationary satellites.

#include <cmath>
#include <vector>

#include <wayfare/core/random.hpp>
#include <wayfare/inertial/ins_state.hpp>
#include <wayfare/nav/gnss_ins.hpp>

namespace wayfare::tests {

/// Rests for `rest_s`, then drives: speed grows to `speed_mps`, the heading swings.
struct Drive {
  Geodetic origin{Angle::degrees(48.7), Angle::degrees(9.1), 300.0};
  double rest_s = 5.0, speed_mps = 12.0, swing_rad = 0.8, period_s = 20.0;

  [[nodiscard]] double speed(double t) const {
    const double d = t - rest_s;
    return d <= 0.0 ? 0.0 : speed_mps * (1.0 - std::exp(-d * d / 30.0));
  }
  [[nodiscard]] double heading(double t) const {
    const double d = t - rest_s - 3.0;
    if (d <= 0.0) return 0.4;
    return 0.4 + swing_rad * (1.0 - std::cos(2.0 * std::numbers::pi * d / period_s));
  }
  [[nodiscard]] SO3d attitude(double t) const {
    return SO3d::exp(heading(t) * Eigen::Vector3d::UnitZ());
  }
  [[nodiscard]] Eigen::Vector3d velocity(double t) const {
    return speed(t) * Eigen::Vector3d(std::cos(heading(t)), std::sin(heading(t)), 0.0);
  }
};

/// Instantaneous readings every `dt_s` and the true states, integrated from the drive's velocity,
/// so that both agree to the order of the integration.
struct Simulated {
  std::vector<ImuSample> imu;
  NavTrajectory truth;
};

inline Simulated simulate(const Drive& drive, double length_s, double dt_s = 0.01) {
  Simulated s;
  const LocalTangentPlane plane(drive.origin);
  Eigen::Vector3d x = Eigen::Vector3d::Zero();
  const auto count = static_cast<int>(length_s / dt_s);
  constexpr double h = 1e-4;
  for (int i = 0; i <= count; ++i) {
    const double t = i * dt_s;
    const EarthAt<double> at = plane.earth(x);
    const Eigen::Vector3d v = drive.velocity(t);
    const LevelRates<double> rates = level_rates(at, v);
    const SO3d q = drive.attitude(t);
    const Eigen::Vector3d turn = drive.attitude(t + h).minus(drive.attitude(t - h)) / (2.0 * h) +
                                 q.inverse() * Eigen::Vector3d(rates.earth + rates.transport);
    Eigen::Vector3d a = (drive.velocity(t + h) - drive.velocity(t - h)) / (2.0 * h) +
                        Eigen::Vector3d((2.0 * rates.earth + rates.transport).cross(v));
    a.z() -= at.gravity_mps2;
    const LogTime time = LogTime::from_seconds(t);
    s.imu.push_back({time, turn, q.inverse() * a});
    s.truth.push_back({time, plane.geodetic(x), v, q});
    // Simpson's rule over the step.
    const Eigen::Vector3d mean =
        (v + 4.0 * drive.velocity(t + 0.5 * dt_s) + drive.velocity(t + dt_s)) / 6.0;
    x += dt_s * Eigen::Vector3d(at.north_scale * mean.x(), at.east_scale * mean.y(), mean.z());
  }
  return s;
}

/// `count` satellites over the sky of `origin`, 22 000 km away.
inline std::vector<Eigen::Vector3d> sky(const Geodetic& origin, int count) {
  std::vector<Eigen::Vector3d> result;
  for (int i = 0; i < count; ++i) {
    const double azimuth = 2.399963 * i, elevation = 0.35 + 1.1 * i / count;
    const Eigen::Vector3d ned(std::cos(elevation) * std::cos(azimuth),
                              std::cos(elevation) * std::sin(azimuth), -std::sin(elevation));
    result.push_back(ecef_from_geodetic(origin) + rotation_ecef_ned(origin) * (2.2e7 * ned));
  }
  return result;
}

struct RangeErrors {
  double range_m = 2.0, rate_mps = 0.1, clock_m = 1000.0, drift_mps = 5.0;
};

inline CorrectedRange range_to(const Eigen::Vector3d& satellite, int number, const NavState& at,
                               const Eigen::Vector3d& lever_body_m,
                               const Eigen::Vector3d& rate_body_radps) {
  const Eigen::Matrix3d r = rotation_ecef_ned(at.position);
  const Eigen::Vector3d p =
      ecef_from_geodetic(at.position) + r * Eigen::Vector3d(at.q_nb * lever_body_m);
  const Eigen::Vector3d v =
      r * (at.velocity_ned_mps + at.q_nb * Eigen::Vector3d(rate_body_radps.cross(lever_body_m)));
  CorrectedRange s;
  s.satellite = {GnssSystem::gps, static_cast<std::uint8_t>(number)};
  s.position_ecef_m = satellite;
  s.velocity_ecef_mps = Eigen::Vector3d(800.0, -1200.0, 300.0);
  s.range_m = (satellite - p).norm();
  s.range_rate_mps = (satellite - p).normalized().dot(s.velocity_ecef_mps - v);
  return s;
}

/// An epoch every `interval_s` from the truth, at readings' times.
inline std::vector<RangeEpoch> simulate_ranges(
    const Drive& drive, const Simulated& s, double interval_s, const RangeErrors& errors,
    std::uint64_t seed, int satellites = 8,
    const Eigen::Vector3d& lever_body_m = Eigen::Vector3d::Zero()) {
  Rng rng(seed);
  const auto where = sky(drive.origin, satellites);
  std::vector<RangeEpoch> epochs;
  const auto every = static_cast<std::size_t>(
      std::lround(interval_s / to_seconds(s.truth[1].time - s.truth[0].time)));
  for (std::size_t i = every; i < s.truth.size(); i += every) {
    const double t = s.truth[i].time.seconds();
    RangeEpoch e{s.truth[i].time, {}};
    for (int k = 0; k < satellites; ++k) {
      CorrectedRange r = range_to(where[static_cast<std::size_t>(k)], k + 1, s.truth[i],
                                  lever_body_m, s.imu[i].angular_rate_radps);
      r.range_m += errors.clock_m + errors.drift_mps * t + rng.normal(0.0, errors.range_m);
      r.range_rate_mps += errors.drift_mps + rng.normal(0.0, errors.rate_mps);
      r.range_sigma_m = std::max(errors.range_m, 0.01);
      r.range_rate_sigma_mps = std::max(errors.rate_mps, 0.001);
      e.satellites.push_back(r);
    }
    epochs.push_back(e);
  }
  return epochs;
}

inline double distance_m(const NavState& a, const NavState& b) {
  return ned_from_geodetic(a.position, b.position).norm();
}

}  // namespace wayfare::tests
