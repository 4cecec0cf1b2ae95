#pragma once

// Subframes of GPS's legacy message, written by IS-GPS-200 (tables 20-I and 20-III): the inverse of
// GpsSubframes.

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include <wayfare/gnss/gps_subframes.hpp>

#include "decode/ubx_streams.hpp"

namespace wayfare::tests {

/// Writes numbers of bits one after the other, from the third word on.
class SubframeWriter {
 public:
  explicit SubframeWriter(unsigned subframe, std::uint32_t time_of_week_6s) {
    put(0x8B, 8), put(0, 16), put(time_of_week_6s, 17), put(0, 2), put(subframe, 3), put(0, 2);
  }
  SubframeWriter& put(std::uint64_t value, unsigned count) {
    for (unsigned k = count; k-- > 0; ++at_) {
      const std::uint64_t bit = k < 64 ? value >> k & 1U : 0;  // reserved ones are more at once
      words_.at(at_ / 24) |= static_cast<std::uint32_t>(bit) << (23 - at_ % 24);
    }
    return *this;
  }
  /// A number in units of 2^exponent.
  SubframeWriter& scaled(double value, unsigned count, int exponent) {
    return put(static_cast<std::uint64_t>(std::llround(std::ldexp(value, -exponent))), count);
  }
  SubframeWriter& angle(double rad, unsigned count, int exponent) {
    return scaled(rad / std::numbers::pi, count, exponent);
  }
  [[nodiscard]] const GpsSubframe& words() const { return words_; }

 private:
  GpsSubframe words_{};
  unsigned at_ = 0;
};

/// Subframes 1 to 3; the issue is that of the orbit.
inline std::array<GpsSubframe, 3> subframes_of(const KeplerianEphemeris& e) {
  const auto issue = static_cast<std::uint32_t>(e.issue);
  const WeekTime toe = week_time(e.toe), toc = week_time(e.toc);
  const auto units = [](Duration t) { return static_cast<std::uint32_t>(to_seconds(t) / 16.0); };
  const auto count = static_cast<std::uint32_t>(to_seconds(toe.of_week) / 6.0);
  SubframeWriter one(1, count), two(2, count + 1), three(3, count + 2);
  one.put(static_cast<std::uint32_t>(toc.week % 1024), 10).put(1, 2).put(0, 4);
  one.put(static_cast<std::uint32_t>(e.health), 6).put(0, 2).put(0, 24 * 3 + 16);
  one.scaled(e.group_delay_s[0], 8, -31).put(issue, 8).put(units(toc.of_week), 16);
  one.scaled(e.clock_drift_rate_per_s, 8, -55).scaled(e.clock_drift, 16, -43);
  one.scaled(e.clock_bias_s, 22, -31);
  two.put(issue, 8).scaled(e.crs_m, 16, -5);
  two.angle(e.mean_motion_difference_radps, 16, -43).angle(e.mean_anomaly_rad, 32, -31);
  two.scaled(e.cuc_rad, 16, -29).scaled(e.eccentricity, 32, -33);
  two.scaled(e.cus_rad, 16, -29).scaled(e.sqrt_semi_major_axis, 32, -19);
  two.put(units(toe.of_week), 16);
  three.scaled(e.cic_rad, 16, -29).angle(e.ascending_node_rad, 32, -31);
  three.scaled(e.cis_rad, 16, -29).angle(e.inclination_rad, 32, -31);
  three.scaled(e.crc_m, 16, -5).angle(e.argument_of_perigee_rad, 32, -31);
  three.angle(e.ascending_node_rate_radps, 24, -43).put(issue, 8);
  three.angle(e.inclination_rate_radps, 14, -43);
  return {one.words(), two.words(), three.words()};
}

/// As RXM-SFRBX; parity bits are zero.
inline decode::UbxBytes sfrbx(int satellite, const GpsSubframe& words) {
  decode::UbxBytes payload = {0, static_cast<std::uint8_t>(satellite), 0, 0, 10, 0, 2, 0};
  for (const std::uint32_t word : words) decode::put_le(payload, word << 6U);
  return decode::ubx(decode::UbxId::rxm_sfrbx, payload);
}

/// Values that the message can hold.
inline KeplerianEphemeris sample_ephemeris() {
  KeplerianEphemeris e;
  e.satellite = {GnssSystem::gps, 17};
  e.toe = e.toc = gps_time(2381, std::chrono::seconds(410400));
  constexpr double kPi = std::numbers::pi;
  e.sqrt_semi_major_axis = std::ldexp(2702026571.0, -19);
  e.eccentricity = std::ldexp(74170257.0, -33);
  e.mean_anomaly_rad = kPi * std::ldexp(-1869434511.0, -31);
  e.mean_motion_difference_radps = kPi * std::ldexp(13199.0, -43);
  e.inclination_rad = kPi * std::ldexp(660190123.0, -31);
  e.inclination_rate_radps = kPi * std::ldexp(-272.0, -43);
  e.ascending_node_rad = kPi * std::ldexp(-1534572011.0, -31);
  e.ascending_node_rate_radps = kPi * std::ldexp(-22286.0, -43);
  e.argument_of_perigee_rad = kPi * std::ldexp(1408999999.0, -31);
  e.cuc_rad = std::ldexp(-482.0, -29), e.cus_rad = std::ldexp(3013.0, -29);
  e.crc_m = std::ldexp(8695.0, -5), e.crs_m = std::ldexp(-537.0, -5);
  e.cic_rad = std::ldexp(6.0, -29), e.cis_rad = std::ldexp(-87.0, -29);
  e.clock_bias_s = std::ldexp(-739787.0, -31), e.clock_drift = std::ldexp(116.0, -43);
  e.group_delay_s[0] = std::ldexp(-17.0, -31);
  e.issue = 83;
  return e;
}

}  // namespace wayfare::tests
