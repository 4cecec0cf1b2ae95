#pragma once

// The corridors of Liu, Atia, Karamat and Noureldin (2015, section 6): a vehicle with one gyro,
// wheels and a laser, straight or in curves. Furnished buildings for a robot with wheels, gyro,
// LiDAR and radar.

#include <array>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/random.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/sensors/recording.hpp>
#include <wayfare/sim/floor_plan.hpp>
#include <wayfare/sim/radar.hpp>
#include <wayfare/sim/simulate_recording.hpp>
#include <wayfare/sim/walkers.hpp>

namespace wayfare::sim {

/// Objects in a corridor and along its walls.
struct CorridorFurniture {
  double door_spacing_m = 4.0;  ///< between the doors of a wall; 0: no doors
  double open_share = 0.0;      ///< share of open doors, into rooms 3 m deep
  double recess_m = 0.06;       ///< depth of closed doors
  double boxes_per_m = 0.0;     ///< cabinets and bins along each wall
  double people_per_m = 0.0;    ///< standing near each wall, 0.3 m across
  double glass_per_m = 0.0;     ///< mean number of 1.5 m panes, transparent to beams, per metre
};

/// A furnished wall from `a_m` to `b_m` with the corridor on its left; all objects lie within
/// `depth_m` of it.
void append_furnished_wall(const Eigen::Vector2d& a_m, const Eigen::Vector2d& b_m, double depth_m,
                           const CorridorFurniture& furniture, Rng& rng,
                           std::vector<Segment>& walls);

/// Three corridors in a row, at right angles.
struct CorridorsParams {
  std::array<double, 3> lengths_m{30.0, 30.0, 30.0};   ///< of the centre line
  double width_m = 2.4;                                ///< of each
  CorridorFurniture furniture{.door_spacing_m = 0.0};  ///< along their walls
};
/// Along x, then along y, then along x again; closed at both ends. Errors: lengths or a width that
/// are not positive or beyond 100 km, more than 100 objects of a kind per metre, doors less than
/// 0.1 m apart.
[[nodiscard]] Result<FloorPlan> three_corridors(const CorridorsParams& params, const Rng& rng);

/// Path through a corridor: along its centre line, or weaving about it.
enum class MotionPattern {
  straight = 1,  ///< along the centre line
  curved = 2,    ///< weaving about it
};

/// The gyro of Liu 2015, section 6.1, in the class of a Crossbow IMU300CC: a constant bias, a bias
/// drifting at a constant rate, a first-order Gauss-Markov part, and white noise.
struct CorridorGyro {
  double max_bias_rad_s = 0.0349;    ///< 2 °/s: the constant part is uniform within ±this
  double drift_rad_s2 = 6e-6;        ///< of random sign
  double walk_sigma_rad_s = 3.5e-5;  ///< of the Gauss-Markov part, 0.002 °/s
  double walk_tau_s = 100.0;         ///< correlation time
  double angle_random_walk_rad_per_sqrt_s = 6.545e-4;  ///< white noise of the rate, 2.25 °/√h
  double range_rad_s = 1.745;                          ///< larger rates are clipped; ±100 °/s
};

/// Place, drive and sensors.
struct CorridorDriveParams {
  CorridorsParams place;                            ///< walls
  MotionPattern pattern = MotionPattern::straight;  ///< path through each corridor
  double speed_m_s = 0.3;                           ///< along straight parts
  double acceleration_m_s2 = 0.2;                   ///< at starts and stops
  double corner_radius_m = 1.0;                     ///< of the path between corridors
  double weave_rad = 0.26;  ///< of the curved pattern: greatest heading relative to the corridor
  double weave_length_m = 4.0;         ///< path length of one side of the weave
  double rest_s = 120.0;               ///< at rest before the drive
  CorridorGyro gyro;                   ///< errors
  double speed_scale_sigma = 0.005;    ///< standard deviation of the wheels' scale error
  double slip_m_per_sqrt_m = 0.0005;   ///< random part of the distance travelled
  double latitude_rad = 0.77;          ///< for the Earth rate measured by the gyro; 44.2° north
  Lidar2dParams lidar = lms200();      ///< at the vehicle's centre
  Duration motion_period{50'000'000};  ///< between samples of wheels and gyro
  Duration scan_period{200'000'000};   ///< between scans

  /// SICK LMS-200: 361 beams of 0.5° over 180°, σ 5 mm, 80 m.
  [[nodiscard]] static Lidar2dParams lms200();
};

/// Section of the drive at a time, as in the tables of Liu 2015.
enum class CorridorSection {
  corridor_1,  ///< the first, with the rest before it
  corner_1,    ///< turn into the second
  corridor_2,  ///< the second
  corner_2,    ///< turn into the third
  corridor_3,  ///< the third
};
/// As in the tables.
[[nodiscard]] std::string_view name_of(CorridorSection section);

/// A drive through the corridors and the truth behind it.
struct CorridorDrive {
  FloorPlan plan;                       ///< walls
  Recording recording;                  ///< scans, wheels, gyro, truth
  std::vector<double> gyro_bias_rad_s;  ///< true bias of each gyro sample
  double speed_scale = 0.0;             ///< metres reported per metre travelled, less one
  std::array<LogTime, 4> section_ends;  ///< of all sections except the last

  /// That contains a time of the drive.
  [[nodiscard]] CorridorSection section_at(LogTime time) const;
};

/// Starts at rest at the origin, along x. Every sensor draws from its own random stream. Errors: as
/// three_corridors, speeds, radii or periods that are not positive, corners wider than the
/// corridors, more than a day.
[[nodiscard]] Result<CorridorDrive> simulate_corridors(const CorridorDriveParams& params,
                                                       const Rng& rng);

/// What a robot is simulated in.
struct World {
  FloorPlan plan;                        ///< walls
  std::vector<Eigen::Vector2d> route_m;  ///< waypoints, m
  std::vector<Reflector> reflectors;     ///< that the radar sees
  std::vector<Carpet> carpets;           ///< where wheels slip
  std::vector<Walker> walkers = {};      ///< people that LiDAR and radar see
};

/// A world of make_world.
struct WorldName {
  std::string_view name;         ///< of make_world
  std::string_view description;  ///< one line
};

/// corridor_loop, corridor_tee, pillar_hall, room, cluttered_room.
[[nodiscard]] std::span<const WorldName> world_names();

/// The world of that name; `rng` determines the positions of its reflectors. An unknown name is an
/// Error that lists the known ones.
[[nodiscard]] Result<World> make_world(std::string_view name, const Rng& rng);

/// A world of any plan: reflectors on its walls, none hidden in sight of the route.
[[nodiscard]] World furnished_world(FloorPlan plan, std::vector<Eigen::Vector2d> route_m,
                                    std::vector<Eigen::Vector2d> frames_m,
                                    const FurnishParams& params, const Rng& rng);

/// How voxels become walls.
struct VoxelWorldParams {
  double voxel_m = 0.15;   ///< side of a voxel
  double lowest_m = -0.6;  ///< lower bound of the slice of voxels that are walls
  double highest_m = 0.4;  ///< upper bound of that slice
  int min_stacked = 2;     ///< voxels on top of each other that make a wall
  double clear_m = 0.45;   ///< least distance of walls to the path
  double step_m = 0.6;     ///< between the route's waypoints
};

/// A real building: the voxels of a map and the path of its carrier, which becomes the route. A
/// wall around everything closes gaps in the map. Errors: an empty slice, a path shorter than two
/// steps, positions that are not finite or beyond 100 km, or more than 67 million cells.
[[nodiscard]] Result<World> world_of_voxels(std::span<const Eigen::Vector3d> voxels_m,
                                            std::span<const Eigen::Vector3d> path_m,
                                            const VoxelWorldParams& params, const Rng& rng);

/// A radar on the robot.
struct RadarMount {
  RadarParams radar;                                   ///< signal processing
  Transform2<frame::Base, frame::Radar> T_base_radar;  ///< its mounting
  Duration period{33'333'333};                         ///< between frames
};

/// A Turtlebot 3 Waffle with an AWR1843 at its front: 0.25 m/s at most, a LiDAR of 360 beams at 5
/// Hz and 3.5 m, radar at 30 Hz and 6 m, wheels and gyro at 20 Hz. Properties of the single robot
/// (wheel sizes, gyro bias) are drawn from `rng`.
struct WorldRobot {
  RobotParams robot;  ///< drive, wheels, gyro and range finder
  RadarMount radar;   ///< radar
};
/// With the errors that `rng` draws.
[[nodiscard]] WorldRobot turtlebot(const Rng& rng);

/// A drive through the world, with every stream of the recording; odometry is from the wheels
/// alone. The same arguments give the same bytes, whatever other sensors there are. Errors as
/// simulate_recording.
[[nodiscard]] Result<Recording> simulate_world(const World& world, const WorldRobot& robot,
                                               const Rng& rng,
                                               const SimulationControl& control = {});

}  // namespace wayfare::sim
