#include <algorithm>
#include <bit>
#include <cmath>
#include <set>

#include <wayfare/decode/ti_decoder.hpp>

namespace wayfare::decode {
namespace {

/// The actual slope of the chip's synthesizer, Hz/s.
double ramp_slope(const TiProfile& p) {
  const double reference_mhz = p.start_ghz < 70.0 ? 2700.0 : 3600.0;
  const double unit = reference_mhz * 900.0 / 0x1p26;  // MHz/µs
  return 1e12 * unit * std::floor(p.slope_mhz_per_us / unit);
}

}  // namespace

TiLimits limits_of(const TiConfig& config) {
  constexpr double kLight = 3e8;
  constexpr int kAngleBins = 64;
  const TiProfile& p = config.profile;
  const double slope = ramp_slope(p), rate = 1e3 * p.sample_ksps;

  std::set<unsigned> tx_masks;
  unsigned transmitters = 0;
  for (const TiChirp& chirp : config.chirps) {
    if (chirp.last < config.frame.first_chirp || chirp.first > config.frame.last_chirp) continue;
    tx_masks.insert(chirp.tx_mask);
    transmitters |= chirp.tx_mask;
  }
  TiLimits l;
  l.transmitters = static_cast<int>(tx_masks.size());
  l.bandwidth_hz = slope * p.samples / rate;
  l.centre_hz = 1e9 * p.start_ghz + slope * 1e-6 * p.adc_start_us + 0.5 * l.bandwidth_hz;
  l.range_bins = static_cast<int>(std::bit_ceil(static_cast<unsigned>(p.samples)));
  l.range_step_m = kLight * rate / (2.0 * slope * l.range_bins);
  l.range_resolution_m = kLight / (2.0 * l.bandwidth_hz);
  l.max_range_m = l.range_step_m * (l.range_bins - 1);
  if (config.max_range_m > 0.0) l.max_range_m = std::min(l.max_range_m, config.max_range_m);

  const int chirps = (config.frame.last_chirp - config.frame.first_chirp + 1) * config.frame.loops;
  const int chirps_per_transmitter = std::max(1, chirps / std::max(1, l.transmitters));
  l.doppler_bins = static_cast<int>(std::bit_ceil(static_cast<unsigned>(chirps_per_transmitter)));
  const double chirp_s = 1e-6 * (p.idle_us + p.ramp_end_us) * l.transmitters;
  l.speed_step_mps = kLight / (2.0 * l.centre_hz * chirp_s * l.doppler_bins);
  l.max_speed_mps = 0.5 * l.speed_step_mps * l.doppler_bins * (config.extended_velocity ? 2 : 1);

  // TX2 is half a wavelength above the others: its virtual antennas measure elevation.
  l.azimuth_antennas =
      std::popcount(config.rx_mask) * std::max(1, std::popcount(transmitters & 5U));
  l.azimuth_resolution = Angle::radians(2.0 / l.azimuth_antennas);
  l.sin_azimuth_step = 2.0 / kAngleBins;
  return l;
}

}  // namespace wayfare::decode
