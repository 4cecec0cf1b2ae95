#pragma once

// Radar reflectors of a building: points on walls, in them and behind them.

#include <cstdint>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/random.hpp>
#include <wayfare/sim/floor_plan.hpp>

namespace wayfare::sim {

/// A point reflector.
struct Reflector {
  static constexpr std::uint32_t kNoMirror = std::numeric_limits<std::uint32_t>::max();

  Eigen::Vector2d at_m = Eigen::Vector2d::Zero();
  /// Power over the thermal noise of a cell of the radar, at 1 m straight ahead; it falls with the
  /// fourth power of the distance.
  double strength_db = 0.0;
  /// Unit normal of its surface, zero for an isotropic reflector: power falls with |cos|^sharpness
  /// of the angle to it.
  Eigen::Vector2d normal = Eigen::Vector2d::Zero();
  double sharpness = 0.0;
  /// Not visible from farther away: a bump of the floor leaves the beam's height.
  double max_range_m = std::numeric_limits<double>::infinity();
  /// A ghost: the mirror image of another reflector behind this segment of the plan, visible only
  /// through it.
  std::uint32_t mirror = kNoMirror;
};

/// How a building's walls reflect. The strengths' defaults, means and standard deviations, come
/// from the comparison with an AWR1843's recordings in benchmarks/reports/2026-11-21_radar_frames.md.
struct FurnishParams {
  struct Kind {
    double spacing_m;    ///< mean distance along a wall; 0: none
    double strength_db;  ///< mean
    double spread_db;    ///< standard deviation
    double sharpness;    ///< of the angle, see Reflector
  };
  Kind plaster{0.08, 34.0, 4.0, 2.0};  ///< roughness of a wall: weak, nearly everywhere
  Kind panel{0.25, 46.0, 4.0, 40.0};   ///< flat pieces with a strong specular echo
  Kind strut{0.6, 48.0, 5.0, 1.0};     ///< metal in the wall and fixtures on it
  double strut_share = 0.5;            ///< share of strut positions that have one
  Kind corner{0.0, 52.0, 4.0, 0.0};    ///< where two walls of `corner_wall_m` or more meet
  double corner_wall_m = 0.03;
  Kind door_frame{0.0, 54.0, 4.0, 0.0};
  /// Objects in the rooms behind the walls, per square metre of the plan's extent.
  double hidden_per_m2 = 0.15;
  double hidden_strength_db = 54.0;
  double hidden_spread_db = 5.0;
  /// Diffuse background: floor, ceiling and small objects. Every range cell has some of it, which
  /// detections must exceed.
  double diffuse_per_m2 = 12.0;
  double diffuse_strength_db = 34.0;
  double diffuse_spread_db = 5.0;
  double floor_per_m2 = 0.8;            ///< bumps of the floor
  double floor_patches_per_m2 = 0.004;  ///< patches of 1 m radius with twenty times as many
  double floor_strength_db = 36.0;
  double floor_spread_db = 4.0;
  double floor_max_range_m = 2.5;
  double ghost_loss_db = 12.0;        ///< of one bounce off a wall
  double ghost_from_db = 46.0;        ///< weaker reflectors have no ghosts
  double ghost_wall_m = 0.8;          ///< shorter walls do not mirror
  double ghost_max_distance_m = 4.0;  ///< from the reflector to the mirroring wall
};

/// Properties of a building beyond its walls.
struct Interior {
  std::vector<Eigen::Vector2d> frames_m;  ///< door posts
  /// Positions where people walk: no hidden object is in sight of one.
  std::vector<Eigen::Vector2d> open_m;
};

/// Reflectors of the walls of `plan`, its floor and the objects behind the walls. The same plan,
/// interior, parameters and generator give the same reflectors.
[[nodiscard]] std::vector<Reflector> furnish(const FloorPlan& plan, const Interior& interior,
                                             const FurnishParams& params, const Rng& rng);

}  // namespace wayfare::sim
