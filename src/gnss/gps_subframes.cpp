#include <wayfare/gnss/gps_subframes.hpp>

#include <cmath>
#include <numbers>

namespace wayfare {
namespace {

/// `count` bits from bit `first` on, both numbered as in IS-GPS-200 without the parity bits: word w
/// (from 1) has the bits 24 (w − 1) + 1 to 24 w.
std::uint32_t bits(const GpsSubframe& words, unsigned first, unsigned count) {
  std::uint32_t value = 0;
  for (unsigned bit = first - 1; bit < first - 1 + count; ++bit)
    value = value << 1U | (words[bit / 24] >> (23 - bit % 24) & 1U);
  return value;
}

/// As bits(), in two's complement.
std::int32_t signed_bits(const GpsSubframe& words, unsigned first, unsigned count) {
  const std::uint32_t value = bits(words, first, count) << (32 - count);
  return static_cast<std::int32_t>(value) >> (32 - count);
}

/// A signed number of `count` bits in units of 2^exponent.
double scaled(const GpsSubframe& words, unsigned first, unsigned count, int exponent) {
  return std::ldexp(signed_bits(words, first, count), exponent);
}
/// The same in semicircles.
double angle(const GpsSubframe& words, unsigned first, unsigned count, int exponent) {
  return std::numbers::pi * scaled(words, first, count, exponent);
}

/// First data bit of word `word`, from 1.
constexpr unsigned word(unsigned number) { return 24 * (number - 1) + 1; }

/// Upper bounds of the user range accuracy index, m (20.3.3.3.1.3).
double accuracy_m(std::uint32_t index) {
  constexpr std::array kMetres = {2.4,  3.4,  4.85, 6.85,  9.65,  13.65,  24.0,  48.0,
                                  96.0, 192., 384., 768.0, 1536., 3072.0, 6144.0};
  return index < kMetres.size() ? kMetres.at(index) : 12288.0;
}

/// Table 20-I, subframe 1.
void take_clock(const GpsSubframe& w, Time<GpsClock> near, KeplerianEphemeris& e) {
  const int week = unrolled_week(static_cast<int>(bits(w, word(3), 10)), near);
  e.accuracy_m = accuracy_m(bits(w, word(3) + 12, 4));
  e.health = static_cast<int>(bits(w, word(3) + 16, 6));
  e.group_delay_s[0] = scaled(w, word(7) + 16, 8, -31);
  e.toc = gps_time(week, std::chrono::seconds(16 * bits(w, word(8) + 8, 16)));
  e.clock_drift_rate_per_s = scaled(w, word(9), 8, -55);
  e.clock_drift = scaled(w, word(9) + 8, 16, -43);
  e.clock_bias_s = scaled(w, word(10), 22, -31);
}

/// Table 20-III, subframes 2 and 3. The week of `toe` is that of the clock, but for a message
/// around the end of a week.
void take_orbit(const GpsSubframe& a, const GpsSubframe& b, KeplerianEphemeris& e) {
  e.issue = static_cast<int>(bits(a, word(3), 8));
  e.crs_m = scaled(a, word(3) + 8, 16, -5);
  e.mean_motion_difference_radps = angle(a, word(4), 16, -43);
  e.mean_anomaly_rad = angle(a, word(4) + 16, 32, -31);
  e.cuc_rad = scaled(a, word(6), 16, -29);
  e.eccentricity = std::ldexp(bits(a, word(6) + 16, 32), -33);
  e.cus_rad = scaled(a, word(8), 16, -29);
  e.sqrt_semi_major_axis = std::ldexp(bits(a, word(8) + 16, 32), -19);
  e.toe = nearest_time_of_week(std::chrono::seconds(16 * bits(a, word(10), 16)), e.toc);
  e.cic_rad = scaled(b, word(3), 16, -29);
  e.ascending_node_rad = angle(b, word(3) + 16, 32, -31);
  e.cis_rad = scaled(b, word(5), 16, -29);
  e.inclination_rad = angle(b, word(5) + 16, 32, -31);
  e.crc_m = scaled(b, word(7), 16, -5);
  e.argument_of_perigee_rad = angle(b, word(7) + 16, 32, -31);
  e.ascending_node_rate_radps = angle(b, word(9), 24, -43);
  e.inclination_rate_radps = angle(b, word(10) + 8, 14, -43);
}

/// Issue of the data of subframe 1, 2 or 3: the eight bits that they share.
std::uint32_t issue_of(const GpsSubframe& words, std::size_t subframe) {
  constexpr std::array kFirst = {word(8), word(3), word(10)};
  return bits(words, kFirst.at(subframe - 1), 8);
}

}  // namespace

std::optional<KeplerianEphemeris> GpsSubframes::add(int satellite, const GpsSubframe& words,
                                                    Time<GpsClock> near) {
  constexpr std::uint32_t kPreamble = 0x8B;
  const std::uint32_t subframe = bits(words, word(2) + 19, 3);
  if (satellite < 1 || satellite > 32 || bits(words, 1, 8) != kPreamble) return std::nullopt;
  if (subframe == 4) take_page(words);
  if (subframe < 1 || subframe > 3) return std::nullopt;
  Parts& parts = satellites_[satellite];
  parts.frames.at(subframe - 1) = words;
  return complete(satellite, parts, near);
}

std::optional<KeplerianEphemeris> GpsSubframes::complete(int satellite, Parts& parts,
                                                         Time<GpsClock> near) {
  const auto& [clock, orbit, rest] = parts.frames;
  if (!clock || !orbit || !rest) return std::nullopt;
  const std::uint32_t issue = issue_of(*clock, 1);
  if (issue != issue_of(*orbit, 2) || issue != issue_of(*rest, 3)) return std::nullopt;
  const auto now = static_cast<int>(issue);
  if (parts.delivered == now) return std::nullopt;
  parts.delivered = now;
  KeplerianEphemeris e;
  e.satellite = {GnssSystem::gps, static_cast<std::uint8_t>(satellite)};
  take_clock(*clock, near, e);
  take_orbit(*orbit, *rest, e);
  return e;
}

void GpsSubframes::take_page(const GpsSubframe& w) {
  constexpr std::uint32_t kPage18 = 56;  // identity of its data
  if (bits(w, word(3) + 2, 6) != kPage18) return;
  KlobucharModel model;
  constexpr std::array kAlpha = {-30, -27, -24, -24}, kBeta = {11, 14, 16, 16};
  for (unsigned k = 0; k < 4; ++k) {
    model.alpha.at(k) = scaled(w, word(3) + 8 + 8 * k, 8, kAlpha.at(k));
    model.beta.at(k) = scaled(w, word(3) + 40 + 8 * k, 8, kBeta.at(k));
  }
  ionosphere_ = model;
  leap_seconds_ = signed_bits(w, word(9), 8);
}

}  // namespace wayfare
