#pragma once

// Messages of u-blox receivers built by the interface description.

#include <cmath>
#include <cstdint>
#include <vector>

#include <wayfare/decode/ubx.hpp>
#include <wayfare/decode/ubx_messages.hpp>

namespace wayfare::decode {

using UbxBytes = std::vector<std::uint8_t>;

inline void append_bytes(UbxBytes& to, const UbxBytes& bytes) {
  to.insert(to.end(), bytes.begin(), bytes.end());
}

template <class T>
void put_le(UbxBytes& out, T value) {
  out.resize(out.size() + sizeof(T));
  store_le(value, &out[out.size() - sizeof(T)]);
}

inline UbxBytes ubx(UbxId id, const UbxBytes& payload) {
  UbxBytes out(payload.size() + 8);
  out.resize(write_ubx(id, payload, out));
  return out;
}

inline UbxBytes rawx(const UbxRawxEpoch& epoch, const std::vector<UbxMeasurement>& measurements) {
  UbxBytes p;
  put_le(p, epoch.time_of_week_s);
  put_le(p, static_cast<std::uint16_t>(epoch.week));
  put_le(p, static_cast<std::int8_t>(epoch.leap_seconds));
  put_le(p, static_cast<std::uint8_t>(measurements.size()));
  put_le(p, static_cast<std::uint8_t>((epoch.leap_seconds_known ? 1 : 0) |
                                      (epoch.clock_reset ? 2 : 0)));
  append_bytes(p, {1, 0, 0});  // version and reserved bytes
  for (const UbxMeasurement& m : measurements) {
    put_le(p, m.pseudorange_m);
    put_le(p, m.carrier_phase_cycles);
    put_le(p, m.doppler_hz);
    append_bytes(
        p, {static_cast<std::uint8_t>(m.gnss), static_cast<std::uint8_t>(m.satellite),
            static_cast<std::uint8_t>(m.signal),
            static_cast<std::uint8_t>(m.gnss == UbxGnss::glonass ? m.glonass_channel + 7 : 0)});
    put_le(p, static_cast<std::uint16_t>(std::lround(1e3 * m.lock_time_s)));
    append_bytes(
        p, {static_cast<std::uint8_t>(m.cn0_db_hz),
            static_cast<std::uint8_t>(std::lround(std::log2(m.pseudorange_sigma_m / 0.01))),
            static_cast<std::uint8_t>(std::isinf(m.carrier_phase_sigma_cycles)
                                          ? 15
                                          : std::lround(m.carrier_phase_sigma_cycles / 0.004)),
            static_cast<std::uint8_t>(std::lround(std::log2(m.doppler_sigma_hz / 0.002))),
            static_cast<std::uint8_t>(
                (m.pseudorange_valid ? 1 : 0) | (m.carrier_phase_valid ? 2 : 0) |
                (m.half_cycle_resolved ? 4 : 0) | (m.half_cycle_subtracted ? 8 : 0)),
            0});
  }
  return ubx(UbxId::rxm_rawx, p);
}

inline std::vector<UbxMeasurement> sample_measurements() {
  UbxMeasurement gps;
  gps.pseudorange_m = 21'234'567.875;
  gps.carrier_phase_cycles = 111'587'345.125;
  gps.doppler_hz = -1234.5F;
  gps.satellite = 17;
  gps.lock_time_s = 64.5;
  gps.cn0_db_hz = 47;
  gps.pseudorange_sigma_m = 0.32;
  gps.carrier_phase_sigma_cycles = 0.008;
  gps.doppler_sigma_hz = 0.256;
  gps.pseudorange_valid = gps.carrier_phase_valid = gps.half_cycle_resolved = true;
  UbxMeasurement galileo = gps;
  galileo.gnss = UbxGnss::galileo;
  galileo.satellite = 31;
  galileo.pseudorange_m = 25'000'000.5;
  galileo.doppler_hz = 2000.25F;
  galileo.cn0_db_hz = 33;
  UbxMeasurement glonass = gps;
  glonass.gnss = UbxGnss::glonass;
  glonass.satellite = 4;
  glonass.glonass_channel = -3;
  glonass.carrier_phase_sigma_cycles = std::numeric_limits<double>::infinity();
  glonass.carrier_phase_valid = glonass.half_cycle_resolved = false;
  glonass.half_cycle_subtracted = true;
  return {gps, galileo, glonass};
}

}  // namespace wayfare::decode
