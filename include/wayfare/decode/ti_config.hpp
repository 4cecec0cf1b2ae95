#pragma once

// The chirp configuration (.cfg) of TI's mmWave demo, and the resulting measurement limits.

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/result.hpp>

namespace wayfare::decode {

/// Parameters of a chirp (`profileCfg`).
struct TiProfile {
  int id = 0;                     ///< of the profile
  double start_ghz = 0.0,         ///< start of the ramp
      idle_us = 0.0,              ///< before the ramp
      adc_start_us = 0.0,         ///< from the start of the ramp
      ramp_end_us = 0.0;          ///< likewise
  double slope_mhz_per_us = 0.0;  ///< of the ramp
  int samples = 0;                ///< ADC samples of a chirp
  double sample_ksps = 0.0;       ///< sampling rate
  double gain_db = 0.0;           ///< of the receivers
};

/// A run of chirps of one profile and one set of transmitters (`chirpCfg`).
struct TiChirp {
  int first = 0,         ///< index
      last = 0,          ///< index, included
      profile = 0;       ///< id of the profile
  unsigned tx_mask = 0;  ///< bit 0 TX1 …
};

/// Order and repetition of the chirps (`frameCfg`).
struct TiFrameTiming {
  int first_chirp = 0,     ///< index
      last_chirp = 0,      ///< index, included
      loops = 0;           ///< repetitions of the run in a frame
  int frames = 0;          ///< 0: until stopped
  double period_ms = 0.0;  ///< from frame to frame
};

/// A threshold detector over range (0) or Doppler (1) bins (`cfarCfg`).
struct TiCfar {
  bool on = false;         ///< used
  double threshold = 0.0;  ///< dB in SDK 3, a scale before
};

/// A checked configuration. The field-of-view limits are those applied by the firmware.
struct TiConfig {
  unsigned rx_mask = 0,                         ///< bit 0 RX1 …
      tx_mask = 0;                              ///< bit 0 TX1 …
  TiProfile profile;                            ///< the one the frame's chirps use
  std::vector<TiChirp> chirps;                  ///< in the order of the file
  TiFrameTiming frame;                          ///< order, repetition, period
  std::array<TiCfar, 2> cfar;                   ///< range, Doppler
  double min_range_m = 0.0,                     ///< `cfarFovCfg`; both 0: not given
      max_range_m = 0.0;                        ///< `cfarFovCfg`
  double min_speed_mps = 0.0,                   ///< `cfarFovCfg`; both 0: not given
      max_speed_mps = 0.0;                      ///< `cfarFovCfg`
  Angle min_azimuth = Angle::degrees(-90.0),    ///< `aoaFovCfg`
      max_azimuth = Angle::degrees(90.0);       ///< `aoaFovCfg`
  Angle min_elevation = Angle::degrees(-90.0),  ///< `aoaFovCfg`
      max_elevation = Angle::degrees(90.0);     ///< `aoaFovCfg`
  bool clutter_removal = false;                 ///< points at rest are removed
  bool extended_velocity = false;               ///< speeds are unwrapped by the firmware
  /// Commands that are irrelevant here or unknown, verbatim.
  std::vector<std::string> others;
};

/// Reads the text of a .cfg file; `source` names it in messages. Errors: a malformed or missing
/// command (by line), values outside the chip's range or inconsistent, advanced frames.
[[nodiscard]] Result<TiConfig> parse_ti_config(std::string_view text, const std::string& source);

/// The grid of the firmware's points, and their limits.
struct TiLimits {
  double centre_hz = 0.0;           ///< mean frequency while the ADC samples
  double bandwidth_hz = 0.0;        ///< swept while the ADC samples
  int transmitters = 0;             ///< in time-division multiplexing
  int range_bins = 0;               ///< of the range transform
  int doppler_bins = 0;             ///< of the Doppler transform
  int azimuth_antennas = 0;         ///< virtual antennas in the horizontal row
  double range_step_m = 0.0;        ///< between range bins
  double range_resolution_m = 0.0;  ///< points closer together are not separated
  double max_range_m = 0.0;         ///< last range bin, or the firmware's limit
  double speed_step_mps = 0.0;      ///< between Doppler bins: also the resolution
  double max_speed_mps = 0.0;       ///< beyond ± this, speed is ambiguous
  Angle azimuth_resolution;         ///< straight ahead
  double sin_azimuth_step = 0.0;    ///< between bins of the angle transform
};

/// The chip ramps at whole multiples of 900 · 3.6e9 / 2^26 Hz/µs (2.7e9 in the 60 GHz band) and
/// rounds a slope down to one (TI, mmWaveLink interface, rlProfileCfg); range and speed grids are
/// computed from that. Speeds use the centre of the sampled window, not the start of the ramp: for
/// a 3.4 GHz sweep at 77 GHz that is 2.8 %. `config` is one that `parse_ti_config` returns. Speed
/// of light as in the firmware, 3·10⁸ m/s, which determines the grid of its points.
[[nodiscard]] TiLimits limits_of(const TiConfig& config);

}  // namespace wayfare::decode
