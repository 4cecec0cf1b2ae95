#pragma once

// Furnished buildings for a robot with wheels, gyro, LiDAR and radar, and its drive through one.

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

/// The world of that name; `rng` determines the positions of its reflectors. An unknown name is an
/// Error that lists the known ones.
[[nodiscard]] Result<World> make_world(std::string_view name, const Rng& rng);

/// A world of any plan: reflectors on its walls, none hidden in sight of the route.
[[nodiscard]] World furnished_world(FloorPlan plan, std::vector<Eigen::Vector2d> route_m,
                                    std::vector<Eigen::Vector2d> frames_m,
                                    const FurnishParams& params, const Rng& rng);

struct VoxelWorldParams {
  double voxel_m = 0.15;
  double lowest_m = -0.6;  ///< lower bound of the slice of voxels that are walls
  double highest_m = 0.4;
  int min_stacked = 2;    ///< voxels on top of each other that make a wall
  double clear_m = 0.45;  ///< least distance of walls to the path
  double step_m = 0.6;    ///< between the route's waypoints
};

/// A real building: the voxels of a map and the path of its carrier, which becomes the route. A
/// wall around everything closes gaps in the map. Errors: an empty slice, or a path shorter than
/// two steps.
[[nodiscard]] Result<World> world_of_voxels(std::span<const Eigen::Vector3d> voxels_m,
                                            std::span<const Eigen::Vector3d> path_m,
                                            const VoxelWorldParams& params, const Rng& rng);

struct RadarMount {
  RadarParams radar;
  Transform2<frame::Base, frame::Radar> T_base_radar;
  Duration period{33'333'333};
};

/// A Turtlebot 3 Waffle with an AWR1843 at its front: 0.25 m/s at most, a LiDAR of 360 beams at 5
/// Hz and 3.5 m, radar at 30 Hz and 6 m, wheels and gyro at 20 Hz. Properties of the single robot
/// (wheel sizes, gyro bias) are drawn from `rng`.
struct WorldRobot {
  RobotParams robot;
  RadarMount radar;
};
[[nodiscard]] WorldRobot turtlebot(const Rng& rng);

/// A drive through the world, with every stream of the recording; odometry is from the wheels
/// alone. The same arguments give the same bytes, whatever other sensors there are. Errors as
/// simulate_recording.
[[nodiscard]] Result<Recording> simulate_world(const World& world, const WorldRobot& robot,
                                               const Rng& rng,
                                               const SimulationControl& control = {});

}  // namespace wayfare::sim
