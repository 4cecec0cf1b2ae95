#include <wayfare/sim/gnss.hpp>

#include <cmath>
#include <numbers>
#include <utility>

#include <Eigen/Geometry>

#include <wayfare/gnss/ephemerides.hpp>

namespace wayfare::sim {
namespace {

constexpr double kTau = 2.0 * std::numbers::pi;

SatelliteMotion on_circle(const WalkerParams& w, int index, Time<GpsClock> time) {
  const int per_plane = w.satellites / w.planes;
  const int plane = index / per_plane, slot = index % per_plane;
  const double rate = std::sqrt(wgs84::kGravitationalConstant_m3ps2 / std::pow(w.radius_m, 3));
  const double earth = wgs84::kEarthRate_radps, t = time.seconds();
  const double node = w.first_node.radians() + kTau * plane / w.planes - std::fmod(earth * t, kTau);
  const double along =
      kTau * slot / per_plane + kTau * w.phasing * plane / w.satellites + std::fmod(rate * t, kTau);
  const double ci = std::cos(w.inclination.radians()), si = std::sin(w.inclination.radians());
  const double cn = std::cos(node), sn = std::sin(node), ca = std::cos(along), sa = std::sin(along);
  SatelliteMotion m;
  m.position_ecef_m =
      w.radius_m * Eigen::Vector3d(cn * ca - sn * ci * sa, sn * ca + cn * ci * sa, si * sa);
  const Eigen::Vector3d inertial =
      w.radius_m * rate *
      Eigen::Vector3d(-cn * sa - sn * ci * ca, -sn * sa + cn * ci * ca, si * ca);
  m.velocity_ecef_mps = inertial - Eigen::Vector3d(0, 0, earth).cross(m.position_ecef_m);
  return m;
}

}  // namespace

Constellation walker_constellation(const WalkerParams& params) {
  WAYFARE_EXPECTS(params.planes > 0 && params.satellites >= params.planes &&
                      params.satellites % params.planes == 0 && params.satellites < 256,
                  "every plane has the same number of satellites");
  Constellation c;
  for (int i = 1; i <= params.satellites; ++i)
    c.satellites.push_back({params.system, static_cast<std::uint8_t>(i)});
  c.motion = [params](SatelliteId id, Time<GpsClock> time) -> std::optional<SatelliteMotion> {
    if (id.system != params.system || id.number < 1 || id.number > params.satellites)
      return std::nullopt;
    return on_circle(params, id.number - 1, time);
  };
  return c;
}

Constellation combined(Constellation a, Constellation b) {
  Constellation both;
  both.satellites = a.satellites;
  both.satellites.insert(both.satellites.end(), b.satellites.begin(), b.satellites.end());
  both.motion = [first = std::move(a.motion), second = std::move(b.motion)](
                    SatelliteId id, Time<GpsClock> t) -> std::optional<SatelliteMotion> {
    if (auto m = first ? first(id, t) : std::nullopt) return m;
    return second ? second(id, t) : std::nullopt;
  };
  return both;
}

Constellation gps_and_galileo() {
  WalkerParams galileo;
  galileo.system = GnssSystem::galileo;
  galileo.planes = 3;
  galileo.radius_m = 29'600'318.0;
  galileo.inclination = Angle::degrees(56.0);
  galileo.first_node = Angle::degrees(43.0);
  return combined(walker_constellation(), walker_constellation(galileo));
}

std::optional<SatelliteMotion> seen_from(const Constellation& constellation, SatelliteId satellite,
                                         Time<GpsClock> reception,
                                         const Eigen::Vector3d& receiver_ecef_m) {
  double travel_s = 0.075;
  for (int round = 0;; ++round) {
    auto m = constellation.motion(satellite, reception - from_seconds(travel_s));
    if (!m) return m;
    const Eigen::AngleAxisd turn(-wgs84::kEarthRate_radps * travel_s, Eigen::Vector3d::UnitZ());
    m->position_ecef_m = turn * m->position_ecef_m;
    m->velocity_ecef_mps = turn * m->velocity_ecef_mps;
    // Each iteration reduces the error by v/c, about 1e-5.
    travel_s = (m->position_ecef_m - receiver_ecef_m).norm() / kSpeedOfLight_mps;
    if (!std::isfinite(travel_s)) return std::nullopt;
    if (round == 3) return m;
  }
}

Angle elevation(const Geodetic& receiver, const Eigen::Vector3d& satellite_ecef_m) {
  const Eigen::Vector3d ned =
      rotation_ecef_ned(receiver).transpose() * (satellite_ecef_m - ecef_from_geodetic(receiver));
  return Angle::radians(std::atan2(-ned.z(), ned.head<2>().norm()));
}

}  // namespace wayfare::sim
