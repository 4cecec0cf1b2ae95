#pragma once

// Satellites of all four systems and a receiver's measurements, computed in inertial axes: shares
// only the satellite states with the code under test.

#include <cmath>
#include <random>

#include <Eigen/Geometry>

#include <wayfare/gnss/correct_ranges.hpp>
#include <wayfare/gnss/ephemerides.hpp>
#include <wayfare/gnss/gps_time.hpp>

namespace wayfare::testing {

inline Time<GpsClock> sky_time() { return gps_time(2051, std::chrono::hours(30)); }

inline KeplerianEphemeris sky_message(GnssSystem system, int number) {
  KeplerianEphemeris k;
  k.satellite = {system, static_cast<std::uint8_t>(number)};
  k.toe = k.toc = sky_time();
  const bool galileo = system == GnssSystem::galileo;
  k.sqrt_semi_major_axis = galileo ? 5440.6 : system == GnssSystem::beidou ? 5282.6 : 5153.7;
  k.eccentricity = 0.001 * number;
  k.inclination_rad = 0.96;
  k.ascending_node_rad = 1.05 * (number % 6) + 0.3 * static_cast<double>(index_of(system));
  k.mean_anomaly_rad =
      std::remainder(2.4 * number + 0.7 * static_cast<double>(index_of(system)), 6.283185307179586);
  k.argument_of_perigee_rad = 0.3;
  k.ascending_node_rate_radps = -8e-9;
  k.crs_m = 30.0, k.cuc_rad = 1e-6, k.cis_rad = 1e-7;
  k.clock_bias_s = 1e-5 * (number - 12);
  k.clock_drift = 1e-11 * number;
  k.group_delay_s[0] = 1e-9 * number, k.group_delay_s[1] = 2e-9;
  return k;
}

inline GlonassEphemeris sky_glonass(int number) {
  // A state from an ellipse of the right size.
  KeplerianEphemeris k = sky_message(GnssSystem::gps, number);
  k.sqrt_semi_major_axis = 5050.5;
  k.inclination_rad = 1.13;
  const SatelliteState s = satellite_state(k, sky_time());
  GlonassEphemeris g;
  g.satellite = {GnssSystem::glonass, static_cast<std::uint8_t>(number)};
  g.toe = sky_time();
  g.channel = number % 13 - 7;
  g.position_m = s.position_ecef_m, g.velocity_mps = s.velocity_ecef_mps;
  g.clock_bias_s = 2e-5, g.clock_drift = 1e-12;
  return g;
}

/// 24 satellites per system.
inline Ephemerides sky_messages() {
  Ephemerides all;
  for (int number = 1; number <= 24; ++number) {
    for (const GnssSystem system : {GnssSystem::gps, GnssSystem::galileo})
      WAYFARE_EXPECTS(all.add(sky_message(system, number)), "a valid message");
    WAYFARE_EXPECTS(all.add(sky_message(GnssSystem::beidou, number + 10)), "a valid message");
    WAYFARE_EXPECTS(all.add(sky_glonass(number)), "a valid message");
  }
  return all;
}

struct SkyReceiver {
  Geodetic position{Angle::degrees(48.78), Angle::degrees(9.17), 320.0};
  Eigen::Vector3d velocity_ned_mps = Eigen::Vector3d::Zero();
  std::array<double, kGnssSystems> clock_m = {250.0, 310.0, 262.0, 235.0};
  double drift_mps = 40.0;
};

inline Eigen::Vector3d to_inertial(const Eigen::Vector3d& ecef, double since_s) {
  return Eigen::AngleAxisd(7.2921151467e-5 * since_s, Eigen::Vector3d::UnitZ()) * ecef;
}

/// c · (time of reception − time of transmission), in system time.
inline double sky_delay_m(const Ephemeris& message, const SkyReceiver& receiver, double at_s) {
  const Eigen::Vector3d ecef =
      ecef_from_geodetic(receiver.position) +
      rotation_ecef_ned(receiver.position) * receiver.velocity_ned_mps * at_s;
  const Eigen::Vector3d there = to_inertial(ecef, at_s);
  double travel_s = 0.07;
  for (int i = 0; i < 8; ++i) {
    const double sent_s = at_s - travel_s;
    const SatelliteState s = satellite_state(message, sky_time() + from_seconds(sent_s));
    travel_s = (to_inertial(s.position_ecef_m, sent_s) - there).norm() / kSpeedOfLight_mps;
  }
  return kSpeedOfLight_mps * travel_s;
}

/// The pseudorange of an observation made `at_s` after sky_time() of true time.
inline double sky_range_m(const Ephemeris& message, const SkyReceiver& receiver, double carrier,
                          double at_s) {
  const double delay_m = sky_delay_m(message, receiver, at_s);
  const SatelliteState s =
      satellite_state(message, sky_time() + from_seconds(at_s - delay_m / kSpeedOfLight_mps));
  const auto system = index_of(satellite_of(message).system);
  return delay_m + receiver.clock_m[system] + receiver.drift_mps * at_s -
         kSpeedOfLight_mps * (s.clock_s - group_delay_s(message, carrier).value());
}

/// Everything above `mask`, without atmosphere and noise; the receiver's clock reads `sky_time()`
/// plus its bias against GPS.
inline ObservationEpoch sky_epoch(const Ephemerides& messages, const SkyReceiver& receiver,
                                  Angle mask = Angle::degrees(10.0)) {
  ObservationEpoch epoch{sky_time() + from_seconds(receiver.clock_m[0] / kSpeedOfLight_mps), {}};
  for (const SatelliteId satellite : messages.satellites()) {
    const Ephemeris& message = messages.of(satellite).front();
    const auto* glonass = std::get_if<GlonassEphemeris>(&message);
    const double carrier =
        *carrier_hz(satellite.system, satellite.system == GnssSystem::beidou ? '2' : '1',
                    glonass != nullptr ? glonass->channel : 0);
    const LineOfSight sight =
        line_of_sight(receiver.position, satellite_state(message, sky_time()).position_ecef_m);
    if (sight.elevation_rad < mask.radians()) continue;
    SatelliteObservation o;
    o.satellite = satellite;
    o.carrier_hz = carrier;
    o.cn0_dbhz = 45.0;
    o.pseudorange_m = sky_range_m(message, receiver, carrier, 0.0);
    // Truncation of the difference over 1 s by third derivatives of 1e-4 m/s³: 4e-6 m/s.
    const double rate = sky_range_m(message, receiver, carrier, 0.5) -
                        sky_range_m(message, receiver, carrier, -0.5);
    o.doppler_hz = -rate * carrier / kSpeedOfLight_mps;
    epoch.satellites.push_back(o);
  }
  return epoch;
}

}  // namespace wayfare::testing
