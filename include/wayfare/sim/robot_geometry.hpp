#pragma once

// A robot whose geometry and clocks are not those that its recording states: what a calibration
// has to find.

#include <wayfare/core/random.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/sensors/recording.hpp>
#include <wayfare/sim/worlds.hpp>

namespace wayfare::sim {

/// True sizes, mountings and delays of a robot.
struct RobotGeometry {
  double left_scale = 1.0;     ///< metres rolled per metre reported
  double right_scale = 1.0;    ///< of the right wheel
  double wheel_base_m = 0.4;   ///< m
  SE2d T_base_laser,           ///< mounting of the laser
      T_base_radar;            ///< mounting of the radar
  double laser_delay_s = 0.0,  ///< stamps of the laser are late by this
      radar_delay_s = 0.0,     ///< of the radar
      gyro_delay_s = 0.0;      ///< of the gyro
};

/// Differs from `robot` by what hand tools leave: wheels by 3 % and the base by 5 % (standard
/// deviations), mountings by 6 cm and 10° (the radar 20°), delays within ±80 ms.
[[nodiscard]] RobotGeometry draw_geometry(const WorldRobot& robot, const Rng& rng);

/// A drive of a robot with this geometry, in a recording that states that of `robot`. Errors as
/// simulate_world.
[[nodiscard]] Result<Recording> simulate_misdescribed(const World& world, const WorldRobot& robot,
                                                      const RobotGeometry& geometry, const Rng& rng,
                                                      const SimulationControl& control = {});

}  // namespace wayfare::sim
