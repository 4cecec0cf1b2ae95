#include <wayfare/gnss/ephemerides.hpp>

#include <algorithm>
#include <cmath>
#include <string>


namespace wayfare {
namespace {

/// The reason a message is invalid, or null.
const char* fault_of(const KeplerianEphemeris& k) {
  const double all[] = {k.sqrt_semi_major_axis,
                        k.eccentricity,
                        k.mean_anomaly_rad,
                        k.mean_motion_difference_radps,
                        k.inclination_rad,
                        k.inclination_rate_radps,
                        k.ascending_node_rad,
                        k.ascending_node_rate_radps,
                        k.argument_of_perigee_rad,
                        k.cuc_rad,
                        k.cus_rad,
                        k.crc_m,
                        k.crs_m,
                        k.cic_rad,
                        k.cis_rad,
                        k.clock_bias_s,
                        k.clock_drift,
                        k.clock_drift_rate_per_s,
                        k.group_delay_s[0],
                        k.group_delay_s[1]};
  for (const double value : all)
    if (!std::isfinite(value)) return "a value is missing or not finite";
  // Medium orbits have √A near 5150 to 5440, geosynchronous ones 6493.
  if (!(k.sqrt_semi_major_axis > 4000.0 && k.sqrt_semi_major_axis < 8000.0))
    return "the orbit's size is not that of a navigation satellite";
  if (!(k.eccentricity >= 0.0 && k.eccentricity < 0.5)) return "the eccentricity is out of range";
  if (!(std::abs(k.crc_m) < 1e5 && std::abs(k.crs_m) < 1e5)) return "a correction is out of range";
  const double angles[] = {k.mean_anomaly_rad,
                           k.inclination_rad,
                           k.ascending_node_rad,
                           k.argument_of_perigee_rad,
                           k.cuc_rad,
                           k.cus_rad,
                           k.cic_rad,
                           k.cis_rad};
  for (const double angle : angles)
    if (!(std::abs(angle) < 10.0)) return "an angle is out of range";
  const double rates[] = {k.mean_motion_difference_radps, k.inclination_rate_radps,
                          k.ascending_node_rate_radps};
  for (const double rate : rates)
    if (!(std::abs(rate) < 1e-4)) return "an angle's rate is out of range";
  const bool clock = std::abs(k.clock_bias_s) < 1.0 && std::abs(k.clock_drift) < 1e-4 &&
                     std::abs(k.clock_drift_rate_per_s) < 1e-6 &&
                     std::abs(k.group_delay_s[0]) < 1e-3 && std::abs(k.group_delay_s[1]) < 1e-3;
  if (!clock) return "a clock value is out of range";
  return k.satellite.system == GnssSystem::glonass ? "GLONASS has no such message" : nullptr;
}

const char* fault_of(const GlonassEphemeris& g) {
  if (!g.position_m.allFinite() || !g.velocity_mps.allFinite() || !g.acceleration_mps2.allFinite())
    return "a value is missing or not finite";
  const double radius = g.position_m.norm(), speed = g.velocity_mps.norm();
  if (!(radius > 2.4e7 && radius < 2.7e7) || !(speed > 1e3 && speed < 6e3) ||
      !(g.acceleration_mps2.norm() < 1e-3))
    return "the orbit is not that of a GLONASS satellite";
  if (g.channel < -7 || g.channel > 13) return "the frequency channel is out of range";
  const bool clock = std::abs(g.clock_bias_s) < 1.0 && std::abs(g.clock_drift) < 1e-4 &&
                     std::abs(g.l2_minus_l1_s) < 1e-3;
  if (!clock) return "a clock value is out of range";
  return g.satellite.system == GnssSystem::glonass ? nullptr : "only GLONASS has such a message";
}

/// Galileo's I/NAV has priority over F/NAV.
int source_rank(const Ephemeris& e) {
  const auto* k = std::get_if<KeplerianEphemeris>(&e);
  return k != nullptr && k->clock_of_e5a ? 1 : 0;
}

bool is_before(const Ephemeris& a, const Ephemeris& b) {
  const auto ta = reference_time(a), tb = reference_time(b);
  return ta != tb ? ta < tb : source_rank(a) < source_rank(b);
}

}  // namespace

Time<GpsClock> reference_time(const Ephemeris& e) {
  return std::visit([](const auto& x) { return x.toe; }, e);
}
SatelliteId satellite_of(const Ephemeris& e) {
  return std::visit([](const auto& x) { return x.satellite; }, e);
}
SatelliteState satellite_state(const Ephemeris& e, Time<GpsClock> time) {
  return std::visit([&](const auto& x) { return satellite_state(x, time); }, e);
}
std::optional<double> group_delay_s(const Ephemeris& e, double carrier_hz) {
  return std::visit([&](const auto& x) { return group_delay_s(x, carrier_hz); }, e);
}
bool is_healthy(const Ephemeris& e, double carrier_hz) {
  return std::visit([&](const auto& x) { return is_healthy(x, carrier_hz); }, e);
}

Result<void> Ephemerides::add(const Ephemeris& ephemeris) {
  const SatelliteId satellite = satellite_of(ephemeris);
  if (const char* fault = std::visit([](const auto& x) { return fault_of(x); }, ephemeris))
    return Error{ErrorCode::invalid, to_string(satellite) + ": " + fault};
  std::vector<Ephemeris>& list = messages_[satellite];
  const auto place = std::lower_bound(list.begin(), list.end(), ephemeris, is_before);
  if (place != list.end() && !is_before(ephemeris, *place)) {
    *place = ephemeris;
  } else {
    list.insert(place, ephemeris);
  }
  return {};
}

void Ephemerides::add(const Ephemerides& other) {
  for (const auto& [satellite, list] : other.messages_)
    for (const Ephemeris& ephemeris : list) (void)add(ephemeris);  // already valid
  if (!gps_ionosphere) gps_ionosphere = other.gps_ionosphere;
  if (!beidou_ionosphere) beidou_ionosphere = other.beidou_ionosphere;
  if (!leap_seconds) leap_seconds = other.leap_seconds;
}

const Ephemeris* Ephemerides::nearest(SatelliteId satellite, Time<GpsClock> time) const {
  const Ephemeris* best = nullptr;
  // Of equal distances the first, which is the I/NAV message.
  Duration least = Duration::max();
  for (const Ephemeris& e : of(satellite)) {
    const Duration difference = reference_time(e) - time;
    const Duration distance = difference < Duration(0) ? -difference : difference;
    if (distance >= least) continue;
    least = distance;
    best = &e;
  }
  return best;
}

std::size_t Ephemerides::size() const {
  std::size_t count = 0;
  for (const auto& entry : messages_) count += entry.second.size();
  return count;
}

std::vector<SatelliteId> Ephemerides::satellites() const {
  std::vector<SatelliteId> result;
  for (const auto& entry : messages_) result.push_back(entry.first);
  return result;
}

const std::vector<Ephemeris>& Ephemerides::of(SatelliteId satellite) const {
  static const std::vector<Ephemeris> kNone;
  const auto found = messages_.find(satellite);
  return found == messages_.end() ? kNone : found->second;
}

}  // namespace wayfare
