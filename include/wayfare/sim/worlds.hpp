#pragma once

// Furnished places for a robot with wheels, gyro, LiDAR and radar, and its run through one.

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/random.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/sim/radar.hpp>
#include <wayfare/sim/reflectors.hpp>
#include <wayfare/sim/simulate_recording.hpp>

namespace wayfare::sim {

struct World {
  FloorPlan plan;
  std::vector<Eigen::Vector2d> route_m;
  std::vector<Reflector> reflectors;
  std::vector<Carpet> carpets;
};

struct WorldName {
  std::string_view name;
  std::string_view description;  ///< one line
};

/// corridor_loop, room, cluttered_room.
[[nodiscard]] std::span<const WorldName> world_names();

/// The world of that name; `rng` decides where its reflectors are, so that seeds differ in the
/// building's inside as well. Fails (naming those there are) where there is no such world.
[[nodiscard]] Result<World> make_world(std::string_view name, const Rng& rng);

/// A world of any plan: reflectors on its walls, the route's places kept free of hidden ones.
[[nodiscard]] World furnished_world(FloorPlan plan, std::vector<Eigen::Vector2d> route_m,
                                    std::vector<Eigen::Vector2d> frames_m,
                                    const FurnishParams& params, const Rng& rng);

struct VoxelWorldParams {
  double voxel_m = 0.15;
  double lowest_m = -0.6;  ///< of the slice of voxels that are walls
  double highest_m = 0.4;
  int fewest = 2;         ///< voxels above each other that make a wall
  double clear_m = 0.45;  ///< nothing stands this near to the way
  double step_m = 0.6;    ///< between the route's places
};

/// A real building: the voxels of a map and the way its carrier went through it, which becomes the
/// route. Where the map has gaps the way out is barred by a wall around all of it. Fails where the
/// slice is empty or the way shorter than two steps.
[[nodiscard]] Result<World> world_of_voxels(std::span<const Eigen::Vector3d> voxels_m,
                                            std::span<const Eigen::Vector3d> way_m,
                                            const VoxelWorldParams& params, const Rng& rng);

struct RadarMount {
  RadarParams radar;
  Transform2<frame::Base, frame::Radar> T_base_radar;
  Duration period{33'333'333};
};

/// A Turtlebot 3 Waffle with an AWR1843 at its front: 0.25 m/s at most, a LiDAR of 360 beams at 5
/// Hz and 3.5 m, radar at 30 Hz and 6 m, wheels and gyro at 20 Hz. What differs from one robot to
/// the next (wheels' sizes, gyro's bias) is drawn from `rng`.
struct WorldRobot {
  RobotParams robot;
  RadarMount radar;
};
[[nodiscard]] WorldRobot turtlebot(const Rng& rng);

/// A run through the world, with every stream of the recording filled; the odometry is the wheels'
/// alone. The same arguments give the same bytes, whatever other sensors there are. Fails as
/// simulate_recording does.
[[nodiscard]] Result<Recording> simulate_world(const World& world, const WorldRobot& robot,
                                               const Rng& rng,
                                               const SimulationControl& control = {});

}  // namespace wayfare::sim
