#include <wayfare/gnss/ephemerides.hpp>

#include <algorithm>
#include <cmath>
#include <string>

namespace wayfare {
namespace {

constexpr const char* kNotFinite = "a value is missing or not finite";
constexpr const char* kClock = "a clock value is out of range";

template <class... Values>
bool finite(Values... values) {
  return (std::isfinite(values) && ...);
}
template <class... Values>
bool below(double limit, Values... values) {
  return ((std::abs(values) < limit) && ...);
}

/// The reason a message is invalid, or null.
const char* fault_of(const KeplerianEphemeris& k) {
  if (!finite(k.sqrt_semi_major_axis, k.eccentricity, k.mean_anomaly_rad,
              k.mean_motion_difference_radps, k.inclination_rad, k.inclination_rate_radps,
              k.ascending_node_rad, k.ascending_node_rate_radps, k.argument_of_perigee_rad,
              k.cuc_rad, k.cus_rad, k.crc_m, k.crs_m, k.cic_rad, k.cis_rad, k.clock_bias_s,
              k.clock_drift, k.clock_drift_rate_per_s, k.group_delay_s[0], k.group_delay_s[1]))
    return kNotFinite;
  // Medium orbits have √A near 5150 to 5440, geosynchronous ones 6493.
  if (!(k.sqrt_semi_major_axis > 4000.0 && k.sqrt_semi_major_axis < 8000.0))
    return "the orbit's size is not that of a navigation satellite";
  if (!(k.eccentricity >= 0.0 && k.eccentricity < 0.5)) return "the eccentricity is out of range";
  if (!below(1e5, k.crc_m, k.crs_m)) return "a correction is out of range";
  if (!below(10.0, k.mean_anomaly_rad, k.inclination_rad, k.ascending_node_rad,
             k.argument_of_perigee_rad, k.cuc_rad, k.cus_rad, k.cic_rad, k.cis_rad))
    return "an angle is out of range";
  if (!below(1e-4, k.mean_motion_difference_radps, k.inclination_rate_radps,
             k.ascending_node_rate_radps))
    return "an angle's rate is out of range";
  if (!below(1.0, k.clock_bias_s) || !below(1e-4, k.clock_drift) ||
      !below(1e-6, k.clock_drift_rate_per_s) ||
      !below(1e-3, k.group_delay_s[0], k.group_delay_s[1]))
    return kClock;
  return k.satellite.system == GnssSystem::glonass ? "GLONASS has no such message" : nullptr;
}

const char* fault_of(const GlonassEphemeris& g) {
  if (!g.position_m.allFinite() || !g.velocity_mps.allFinite() || !g.acceleration_mps2.allFinite())
    return kNotFinite;
  const double radius = g.position_m.norm(), speed = g.velocity_mps.norm();
  if (!(radius > 2.4e7 && radius < 2.7e7) || !(speed > 1e3 && speed < 6e3) ||
      !(g.acceleration_mps2.norm() < 1e-3))
    return "the orbit is not that of a GLONASS satellite";
  if (g.channel < -7 || g.channel > 13) return "the frequency channel is out of range";
  if (!below(1.0, g.clock_bias_s) || !below(1e-4, g.clock_drift) || !below(1e-3, g.l2_minus_l1_s))
    return kClock;
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

const char* name_of(GnssSystem system) {
  constexpr const char* kNames[] = {"GPS", "GLONASS", "Galileo", "BeiDou"};
  return kNames[index_of(system)];
}

std::optional<GnssSystem> system_of(char letter) {
  for (const GnssSystem system : kAllGnssSystems)
    if (letter_of(system) == letter) return system;
  return std::nullopt;
}

std::string to_string(SatelliteId satellite) {
  std::string text(1, letter_of(satellite.system));
  if (satellite.number < 10) text += '0';
  return text += std::to_string(satellite.number);
}

std::optional<SatelliteId> parse_satellite(std::string_view text) {
  char letter = 'G';
  if (text.size() == 3) {
    if (text[0] != ' ') letter = text[0];
    text.remove_prefix(1);
  }
  const std::optional<GnssSystem> system = system_of(letter);
  if (!system || text.size() != 2) return std::nullopt;
  const auto digit = [](char c) { return c >= '0' && c <= '9'; };
  if ((text[0] != ' ' && !digit(text[0])) || !digit(text[1])) return std::nullopt;
  const int number = (text[0] == ' ' ? 0 : text[0] - '0') * 10 + (text[1] - '0');
  if (number == 0) return std::nullopt;
  return SatelliteId{*system, static_cast<std::uint8_t>(number)};
}

std::optional<double> carrier_hz(GnssSystem system, char band, int glonass_channel) {
  const auto pick = [&](std::string_view bands, std::initializer_list<double> carriers) {
    const std::size_t at = bands.find(band);
    return at == bands.npos ? std::nullopt : std::optional<double>(carriers.begin()[at]);
  };
  switch (system) {
    case GnssSystem::gps:
      return pick("125", {carrier::kL1, carrier::kL2, carrier::kL5});
    case GnssSystem::galileo:
      return pick("15786",
                  {carrier::kE1, carrier::kE5a, carrier::kE5b, carrier::kE5, carrier::kE6});
    case GnssSystem::beidou:
      return pick("21576",
                  {carrier::kB1I, carrier::kB1C, carrier::kL5, carrier::kB2I, carrier::kB3I});
    case GnssSystem::glonass:
      break;
  }
  if (band == '1') return carrier::kGlonassL1 + glonass_channel * carrier::kGlonassL1Step;
  if (band == '2') return carrier::kGlonassL2 + glonass_channel * carrier::kGlonassL2Step;
  return std::nullopt;
}

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
    const Time<GpsClock> toe = reference_time(e);
    const Duration distance = toe < time ? time - toe : toe - time;
    if (best != nullptr && distance >= least) continue;
    least = distance;
    best = &e;
  }
  return best;
}

std::size_t Ephemerides::size() const {
  std::size_t count = 0;
  for (const auto& [satellite, list] : messages_) count += list.size();
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
