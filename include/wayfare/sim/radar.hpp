#pragma once

// Radar reflectors of a building, on walls, in them and behind them, and a millimetre-wave radar
// like the AWR1843, down to the cells of its signal processing: range and Doppler transform,
// constant false alarm rate threshold in both, angle transform over eight virtual antennas. Points
// are therefore those of the device: on its grid, many or none per object, with side lobes, and
// none where the neighbourhood is as bright.

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/random.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/sensors/scans.hpp>
#include <wayfare/sim/floor_plan.hpp>

namespace wayfare::sim {

/// A point reflector.
struct Reflector {
  /// Not a ghost.
  static constexpr std::uint32_t kNoMirror = std::numeric_limits<std::uint32_t>::max();

  Eigen::Vector2d at_m = Eigen::Vector2d::Zero();  ///< place, m, in the plan's frame
  /// Power over the thermal noise of a cell of the radar, at 1 m straight ahead; it falls with the
  /// fourth power of the distance.
  double strength_db = 0.0;
  /// Unit normal of its surface, zero for an isotropic reflector: power falls with |cos|^sharpness
  /// of the angle to it.
  Eigen::Vector2d normal = Eigen::Vector2d::Zero();
  double sharpness = 0.0;  ///< exponent of |cos|; 0: isotropic
  /// Not visible from farther away: a bump of the floor leaves the beam's height.
  double max_range_m = std::numeric_limits<double>::infinity();
  /// A ghost: the mirror image of another reflector behind this segment of the plan, visible only
  /// through it.
  std::uint32_t mirror = kNoMirror;
  Eigen::Vector2d velocity_m_s = Eigen::Vector2d::Zero();  ///< over ground, the plan's axes
};

/// How a building's walls reflect. The strengths' defaults, means and standard deviations, come
/// from the comparison with an AWR1843's recordings in
/// benchmarks/reports/2026-11-21_radar_frames.md.
struct FurnishParams {
  /// Density and strength of one kind of reflector.
  struct Kind {
    double spacing_m;    ///< mean distance along a wall; 0: none
    double strength_db;  ///< mean
    double spread_db;    ///< standard deviation
    double sharpness;    ///< of the angle, see Reflector
  };
  Kind plaster{0.08, 34.0, 4.0, 2.0};    ///< roughness of a wall: weak, nearly everywhere
  Kind panel{0.25, 46.0, 4.0, 40.0};     ///< flat pieces with a strong specular echo
  Kind strut{0.6, 48.0, 5.0, 1.0};       ///< metal in the wall and fixtures on it
  double strut_share = 0.5;              ///< share of strut positions that have one
  Kind corner{0.0, 52.0, 4.0, 0.0};      ///< where two walls of `corner_wall_m` or more meet
  double corner_wall_m = 0.03;           ///< m, length of a wall with corners
  Kind door_frame{0.0, 54.0, 4.0, 0.0};  ///< on Interior::frames_m
  /// Objects in the rooms behind the walls, per square metre of the plan's extent.
  double hidden_per_m2 = 0.15;
  double hidden_strength_db = 54.0;  ///< mean of these objects
  double hidden_spread_db = 5.0;     ///< their standard deviation
  /// Diffuse background: floor, ceiling and small objects. Every range cell has some of it, which
  /// detections must exceed.
  double diffuse_per_m2 = 12.0;
  double diffuse_strength_db = 34.0;    ///< mean of the background
  double diffuse_spread_db = 5.0;       ///< its standard deviation
  double floor_per_m2 = 0.8;            ///< bumps of the floor
  double floor_patches_per_m2 = 0.004;  ///< patches of 1 m radius with twenty times as many
  double floor_strength_db = 36.0;      ///< mean of the bumps
  double floor_spread_db = 4.0;         ///< their standard deviation
  double floor_max_range_m = 2.5;       ///< farther bumps leave the beam
  double ghost_loss_db = 12.0;          ///< of one bounce off a wall
  double ghost_from_db = 46.0;          ///< weaker reflectors have no ghosts
  double ghost_wall_m = 0.8;            ///< shorter walls do not mirror
  double ghost_max_distance_m = 4.0;    ///< from the reflector to the mirroring wall
};

/// Properties of a building beyond its walls.
struct Interior {
  std::vector<Eigen::Vector2d> frames_m;  ///< door posts
  /// Positions where people walk: no hidden object is in sight of one.
  std::vector<Eigen::Vector2d> open_m;
};

/// Reflectors of the walls of `plan`, its floor and the objects behind the walls. The same plan,
/// interior, parameters and generator give the same reflectors, ten million at most.
[[nodiscard]] std::vector<Reflector> furnish(const FloorPlan& plan, const Interior& interior,
                                             const FurnishParams& params, const Rng& rng);

/// The default is the AWR1843 with the demonstration firmware's "best range resolution" settings:
/// 77 GHz, two transmitters and four receivers, 256 samples, 16 chirps each.
struct RadarParams {
  double range_bin_m = 0.0436;      ///< between range bins
  double doppler_bin_m_s = 0.1217;  ///< between Doppler bins
  std::size_t doppler_bins = 16;    ///< a power of two to 1024; speeds alias at half of them
  std::size_t azimuth_bins = 64;    ///< equal steps of the sine, over [-1, 1); 1024 at most
  double wavelength_m = 0.003785;   ///< of the carrier
  double min_range_m = 0.5;         ///< nearer points are antenna coupling, and cut off
  double max_range_m = 6.0;         ///< farther points are cut off
  Angle min_azimuth = Angle::degrees(-180.0);  ///< field of view: points beyond are cut off
  Angle max_azimuth = Angle::degrees(180.0);   ///< its other side
  std::size_t max_points = 100;                ///< capacity of a frame; the farthest are cut off
  double threshold_db = 9.0;       ///< over the mean of the neighbours, in range and in Doppler
  std::size_t range_guard = 4;     ///< guard cells on either side
  std::size_t range_window = 8;    ///< neighbours on either side; the darker side counts
  std::size_t doppler_guard = 2;   ///< guard cells on either side
  std::size_t doppler_window = 4;  ///< neighbours on either side, both count
  /// A second point in a cell if the next peak in angle has this share of the first one's power:
  /// the firmware's one half, taken as a ratio of amplitudes, which agrees better with recordings.
  double second_peak = 0.25;
  double beam_exponent = 6.0;  ///< two-way power falls with this power of cos(azimuth)
  double wall_loss_db = 8.0;   ///< two-way loss of a wall in between
  int walls_seen_through = 1;  ///< walls behind which reflectors have echoes
};

/// The frame at `time` of a radar at `T_plan_radar` that moves with `velocity_m_s` (in its own
/// axes). `rng` draws the receivers' noise; the echoes are determined by the geometry to a fraction
/// of the wavelength. A reflector with numbers that are not finite, or with a mirror that is not of
/// this plan, has no echo; nor has any at a velocity that is not finite.
[[nodiscard]] RadarScan simulate_radar(const FloorPlan& plan, std::span<const Reflector> reflectors,
                                       const SE2d& T_plan_radar,
                                       const Eigen::Vector2d& velocity_m_s, LogTime time,
                                       const RadarParams& params, Rng& rng);

}  // namespace wayfare::sim
