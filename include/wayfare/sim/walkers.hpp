#pragma once

// People who walk through a world, as a LiDAR at the height of their legs and a radar see them.

#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/random.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/sensors/scans.hpp>
#include <wayfare/sim/floor_plan.hpp>
#include <wayfare/sim/radar.hpp>

namespace wayfare::sim {

/// A person walking to and fro between two points at a constant speed. A foot that is on the floor
/// is at rest.
struct Walker {
  Eigen::Vector2d from_m = Eigen::Vector2d::Zero();  ///< one end of the path, m
  Eigen::Vector2d to_m = Eigen::Vector2d::Zero();    ///< the other
  double speed_m_s = 1.0;                            ///< of the body
  double start_m = 0.0;                              ///< distance walked at time 0, from `from_m`
  double stride_m = 0.7;                             ///< of a step
  double strength_db = 50;  ///< of the body's echo at 1 m, see Reflector; each leg's is 6 dB less
};

/// A part of a walker at a time.
struct WalkerPart {
  Eigen::Vector2d at_m;          ///< centre, m
  Eigen::Vector2d velocity_m_s;  ///< over ground
};

/// Body, left leg and right leg at a time. A path shorter than a micrometre is stood on.
struct WalkerParts {
  WalkerPart body,  ///< trunk
      left,         ///< leg
      right;        ///< leg
};
/// Of one walker.
[[nodiscard]] WalkerParts walker_at(const Walker& walker, LogTime time);

/// Reflectors of all walkers at a time.
[[nodiscard]] std::vector<Reflector> reflectors_of(std::span<const Walker> walkers, LogTime time);

/// Beams that meet a leg, 6 cm in radius, before what they measured get its range, with noise of
/// `params`; `T_plan_laser` at the scan's time.
void overlay_walkers(LaserScan& scan, std::span<const Walker> walkers, const SE2d& T_plan_laser,
                     const Lidar2dParams& params, Rng& rng);

/// `count` walkers on legs of the route longer than four metres, drawn by their lengths, at 0.5 to
/// 1.4 m/s, at least 0.55 m beside the route; none where no leg is as long.
[[nodiscard]] std::vector<Walker> walkers_along(std::span<const Eigen::Vector2d> route_m,
                                                std::size_t count, Rng rng);

}  // namespace wayfare::sim
