#include <wayfare/gnss/ephemerides.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <wayfare/core/contract.hpp>

#include <wayfare/gnss/gps_time.hpp>

namespace wayfare {
namespace {

/// Each system's constants, with which its broadcast orbits are fitted.
struct EarthConstants {
  double mu_m3ps2;
  double rate_radps;
};

EarthConstants earth_of(GnssSystem system) {
  switch (system) {
    case GnssSystem::galileo:
      return {3.986004418e14, 7.2921151467e-5};
    case GnssSystem::beidou:
      return {3.986004418e14, 7.2921150e-5};
    default:
      return {3.9860050e14, 7.2921151467e-5};
  }
}

/// E − e sin E = M by Newton with a limited step, for nearly parabolic orbits.
double eccentric_anomaly(double mean_anomaly, double e) {
  double result = mean_anomaly + e * std::sin(mean_anomaly);
  for (int i = 0; i < 50; ++i) {
    const double step = (result - e * std::sin(result) - mean_anomaly) / (1 - e * std::cos(result));
    result -= std::clamp(step, -1.0, 1.0);
    if (std::abs(step) < 1e-14) break;
  }
  return result;
}

/// A value and its rate.
struct Rated {
  double value, rate;
};

/// cos·c + sin·s of an angle: the form of every harmonic correction.
Rated harmonic(double c, double s, const Rated& angle) {
  const double co = std::cos(angle.value), si = std::sin(angle.value);
  return {c * co + s * si, (s * co - c * si) * angle.rate};
}

/// The satellite in its orbital plane, and the plane's inclination.
struct InPlane {
  Rated x, y, inclination;
};

InPlane in_plane(const KeplerianEphemeris& k, double tk, const Rated& anomaly) {
  const double e = k.eccentricity, a = k.sqrt_semi_major_axis * k.sqrt_semi_major_axis;
  const double se = std::sin(anomaly.value), ce = std::cos(anomaly.value);
  const double root = std::sqrt(1.0 - e * e);
  const double true_anomaly = std::atan2(root * se, ce - e);
  const Rated phi{true_anomaly + k.argument_of_perigee_rad, root * anomaly.rate / (1.0 - e * ce)};
  const Rated twice{2.0 * phi.value, 2.0 * phi.rate};
  const Rated du = harmonic(k.cuc_rad, k.cus_rad, twice);
  const Rated dr = harmonic(k.crc_m, k.crs_m, twice);
  const Rated di = harmonic(k.cic_rad, k.cis_rad, twice);
  const Rated u{phi.value + du.value, phi.rate + du.rate};
  const Rated r{a * (1.0 - e * ce) + dr.value, a * e * se * anomaly.rate + dr.rate};
  const double cu = std::cos(u.value), su = std::sin(u.value);
  return {{r.value * cu, r.rate * cu - r.value * su * u.rate},
          {r.value * su, r.rate * su + r.value * cu * u.rate},
          {k.inclination_rad + di.value + k.inclination_rate_radps * tk,
           k.inclination_rate_radps + di.rate}};
}

/// From the orbital plane to the target frame, in which its node is at `node`.
void leave_plane(const InPlane& p, const Rated& node, SatelliteState& state) {
  const double co = std::cos(node.value), so = std::sin(node.value);
  const double ci = std::cos(p.inclination.value), si = std::sin(p.inclination.value);
  // Components perpendicular to the node in the equator, and along the pole.
  const Rated across{p.y.value * ci, p.y.rate * ci - p.y.value * si * p.inclination.rate};
  const Rated up{p.y.value * si, p.y.rate * si + p.y.value * ci * p.inclination.rate};
  state.position_ecef_m = {p.x.value * co - across.value * so, p.x.value * so + across.value * co,
                           up.value};
  state.velocity_ecef_mps = {
      p.x.rate * co - across.rate * so - state.position_ecef_m.y() * node.rate,
      p.x.rate * so + across.rate * co + state.position_ecef_m.x() * node.rate, up.rate};
}

/// BDS-SIS-ICD table 5-10: geostationary orbits are in a non-rotating frame tilted by −5° about x;
/// this transforms them to Earth-fixed axes.
void from_geostationary_frame(double earth_angle, double earth_rate, SatelliteState& state) {
  constexpr double kTilt = -5.0 * std::numbers::pi / 180.0;
  const double ct = std::cos(kTilt), st = std::sin(kTilt);
  const double ca = std::cos(earth_angle), sa = std::sin(earth_angle);
  const Eigen::Matrix3d tilt = (Eigen::Matrix3d() << 1, 0, 0, 0, ct, st, 0, -st, ct).finished();
  const Eigen::Matrix3d turn = (Eigen::Matrix3d() << ca, sa, 0, -sa, ca, 0, 0, 0, 1).finished();
  const Eigen::Matrix3d turn_rate =
      earth_rate * (Eigen::Matrix3d() << -sa, ca, 0, -ca, -sa, 0, 0, 0, 0).finished();
  state.velocity_ecef_mps =
      turn * (tilt * state.velocity_ecef_mps) + turn_rate * (tilt * state.position_ecef_m);
  state.position_ecef_m = turn * (tilt * state.position_ecef_m);
}

/// Time of week of the orbit's reference time, s, in the system's week.
double seconds_of_week(const KeplerianEphemeris& k) {
  const bool beidou = k.satellite.system == GnssSystem::beidou;
  return to_seconds(week_time(beidou ? k.toe - kGpsMinusBeidou : k.toe).of_week);
}

constexpr double kGlonassMu = 3.9860044e14;
constexpr double kGlonassJ2 = 1.0826257e-3;
constexpr double kGlonassRadius = 6378136.0;
constexpr double kGlonassEarthRate = 7.292115e-5;

using OrbitState = Eigen::Matrix<double, 6, 1>;

/// GLONASS ICD 5.1 (A.3.1.2.1): the equations of motion in Earth-fixed axes.
OrbitState derivative(const OrbitState& s, const Eigen::Vector3d& sun_and_moon) {
  const double x = s[0], y = s[1], z = s[2], w = kGlonassEarthRate;
  const double r2 = s.head<3>().squaredNorm(), r3 = r2 * std::sqrt(r2);
  const double a = 1.5 * kGlonassJ2 * kGlonassMu * kGlonassRadius * kGlonassRadius / (r2 * r3);
  const double b = 5.0 * z * z / r2, c = -kGlonassMu / r3 - a * (1.0 - b);
  OrbitState d;
  d << s[3], s[4], s[5], (c + w * w) * x + 2.0 * w * s[4] + sun_and_moon.x(),
      (c + w * w) * y - 2.0 * w * s[3] + sun_and_moon.y(), (c - 2.0 * a) * z + sun_and_moon.z();
  return d;
}

OrbitState runge_kutta(const OrbitState& s, double h, const Eigen::Vector3d& acceleration) {
  const OrbitState k1 = derivative(s, acceleration);
  const OrbitState k2 = derivative(s + 0.5 * h * k1, acceleration);
  const OrbitState k3 = derivative(s + 0.5 * h * k2, acceleration);
  const OrbitState k4 = derivative(s + h * k3, acceleration);
  return s + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
}

bool is_near(double carrier_hz, double nominal) { return std::abs(carrier_hz - nominal) < 1e6; }

}  // namespace

SatelliteState satellite_state(const KeplerianEphemeris& k, Time<GpsClock> time) {
  const EarthConstants earth = earth_of(k.satellite.system);
  const double tk = to_seconds(time - k.toe);
  const double a = k.sqrt_semi_major_axis * k.sqrt_semi_major_axis;
  const double n = std::sqrt(earth.mu_m3ps2 / (a * a * a)) + k.mean_motion_difference_radps;
  const double eccentric = eccentric_anomaly(k.mean_anomaly_rad + n * tk, k.eccentricity);
  const Rated anomaly{eccentric, n / (1.0 - k.eccentricity * std::cos(eccentric))};

  SatelliteState state;
  const InPlane plane = in_plane(k, tk, anomaly);
  const double node_of_week = k.ascending_node_rad - earth.rate_radps * seconds_of_week(k);
  if (is_beidou_geostationary(k.satellite)) {
    leave_plane(plane,
                {node_of_week + k.ascending_node_rate_radps * tk, k.ascending_node_rate_radps},
                state);
    from_geostationary_frame(earth.rate_radps * tk, earth.rate_radps, state);
  } else {
    const double rate = k.ascending_node_rate_radps - earth.rate_radps;
    leave_plane(plane, {node_of_week + rate * tk, rate}, state);
  }

  const double tc = to_seconds(time - k.toc);
  // IS-GPS-200 20.3.3.3.3.1: F e √A sin E with F = −2 √μ / c².
  const double f = -2.0 * std::sqrt(earth.mu_m3ps2) / (kSpeedOfLight_mps * kSpeedOfLight_mps) *
                   k.eccentricity * k.sqrt_semi_major_axis;
  state.clock_s = k.clock_bias_s + (k.clock_drift + k.clock_drift_rate_per_s * tc) * tc +
                  f * std::sin(eccentric);
  state.clock_drift =
      k.clock_drift + 2.0 * k.clock_drift_rate_per_s * tc + f * std::cos(eccentric) * anomaly.rate;
  return state;
}

SatelliteState satellite_state(const GlonassEphemeris& g, Time<GpsClock> time, double step_s) {
  WAYFARE_EXPECTS(step_s > 0.0, "the step is positive");
  constexpr double kMostSteps = 1e5;
  const double dt = to_seconds(time - g.toe), needed = std::ceil(std::abs(dt) / step_s);
  OrbitState s;
  s << g.position_m, g.velocity_mps;
  if (!(needed <= kMostSteps)) s.setConstant(std::numeric_limits<double>::quiet_NaN());
  const int steps = needed <= kMostSteps ? std::max(1, static_cast<int>(needed)) : 0;
  for (int i = 0; i < steps; ++i) s = runge_kutta(s, dt / steps, g.acceleration_mps2);
  return {s.head<3>(), s.tail<3>(), g.clock_bias_s + g.clock_drift * dt, g.clock_drift};
}

std::optional<double> group_delay_s(const KeplerianEphemeris& k, double carrier_hz) {
  const auto squared_ratio = [&](double to) { return to * to / (carrier_hz * carrier_hz); };
  switch (k.satellite.system) {
    case GnssSystem::gps:  // IS-GPS-200 20.3.3.3.3.2: the clock is that of L1/L2 P(Y) together
      if (is_near(carrier_hz, carrier::kL5)) return std::nullopt;
      return k.group_delay_s[0] * squared_ratio(carrier::kL1);
    case GnssSystem::galileo:  // Galileo OS SIS ICD 5.1.5
      if (is_near(carrier_hz, carrier::kE6)) return std::nullopt;
      return k.group_delay_s[k.clock_of_e5a ? 0 : 1] * squared_ratio(carrier::kE1);
    case GnssSystem::beidou:  // BDS-SIS-ICD 5.2.4.10: the clock is that of B3
      if (is_near(carrier_hz, carrier::kB1I)) return k.group_delay_s[0];
      if (is_near(carrier_hz, carrier::kB2I)) return k.group_delay_s[1];
      if (is_near(carrier_hz, carrier::kB3I)) return 0.0;
      return std::nullopt;
    case GnssSystem::glonass:
      break;
  }
  return std::nullopt;
}

std::optional<double> group_delay_s(const GlonassEphemeris& g, double carrier_hz) {
  const bool second_band = carrier_hz < 1.4e9;
  return second_band ? g.l2_minus_l1_s : 0.0;
}

bool is_healthy(const KeplerianEphemeris& k, double carrier_hz) {
  if (k.satellite.system != GnssSystem::galileo) return k.health == 0;
  // RINEX 3.04 table A8: three bits per signal, E1-B lowest, then E5a, E5b.
  if (is_near(carrier_hz, carrier::kE5a)) return ((k.health >> 3) & 7) == 0;
  if (is_near(carrier_hz, carrier::kE5b)) return ((k.health >> 6) & 7) == 0;
  return (k.health & 7) == 0;
}

bool is_healthy(const GlonassEphemeris& g, double) { return g.health == 0; }

bool is_beidou_geostationary(SatelliteId s) {
  return s.system == GnssSystem::beidou && (s.number <= 5 || s.number >= 59);
}

}  // namespace wayfare
