#pragma once

// A millimetre-wave radar like the AWR1843, down to the cells of its signal processing: range and
// Doppler transform, constant false alarm rate threshold in both, angle transform over eight
// virtual antennas. Points are therefore those of the device: on its grid, many or none per object,
// with side lobes, and none where the neighbourhood is as bright.

#include <cstddef>
#include <span>

#include <Eigen/Core>

#include <wayfare/core/random.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/sensors/radar_scan.hpp>
#include <wayfare/sim/reflectors.hpp>

namespace wayfare::sim {

/// The default is the AWR1843 with the demonstration firmware's "best range resolution" settings:
/// 77 GHz, two transmitters and four receivers, 256 samples, 16 chirps each.
struct RadarParams {
  double range_bin_m = 0.0436;
  double doppler_bin_m_s = 0.1217;
  std::size_t doppler_bins = 16;  ///< a power of two; speeds alias at half of them
  std::size_t azimuth_bins = 64;  ///< equal steps of the sine, over [-1, 1)
  double wavelength_m = 0.003785;
  double min_range_m = 0.5;  ///< nearer points are antenna coupling, and cut off
  double max_range_m = 6.0;
  std::size_t max_points = 100;  ///< capacity of a frame; the farthest are cut off
  double threshold_db = 9.0;     ///< over the mean of the neighbours, in range and in Doppler
  std::size_t range_guard = 4;   ///< guard cells on either side
  std::size_t range_window = 8;  ///< neighbours on either side; the darker side counts
  std::size_t doppler_guard = 2;
  std::size_t doppler_window = 4;  ///< neighbours on either side, both count
  /// A second point in a cell if the next peak in angle has this share of the first one's power:
  /// the firmware's one half, taken as a ratio of amplitudes, which agrees better with recordings.
  double second_peak = 0.25;
  double beam_exponent = 6.0;  ///< two-way power falls with this power of cos(azimuth)
  double wall_loss_db = 8.0;   ///< two-way loss of a wall in between
  int walls_seen_through = 1;
};

/// The frame at `time` of a radar at `T_plan_radar` that moves with `velocity_m_s` (in its own
/// axes). `rng` draws the receivers' noise; the echoes are determined by the geometry to a fraction
/// of the wavelength.
[[nodiscard]] RadarScan simulate_radar(const FloorPlan& plan, std::span<const Reflector> reflectors,
                                       const SE2d& T_plan_radar,
                                       const Eigen::Vector2d& velocity_m_s, LogTime time,
                                       const RadarParams& params, Rng& rng);

}  // namespace wayfare::sim
