#pragma once

// The simulation of Liu, Atia, Karamat and Noureldin (2015, section 6): three corridors, two
// corners, a vehicle with one gyro, wheels and a laser that drives through straight or in curves.

#include <array>
#include <string_view>
#include <utility>
#include <vector>

#include <wayfare/core/random.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/sensors/recording.hpp>
#include <wayfare/sim/floor_plan.hpp>
#include <wayfare/sim/lidar_2d.hpp>

namespace wayfare::sim {

/// What stands in a corridor and along its walls.
struct CorridorFurniture {
  double door_spacing_m = 4.0;  ///< of doors along each wall; 0: none
  double open_share = 0.0;      ///< of the doors that stand open, into rooms 3 m deep
  double recess_m = 0.06;       ///< closed doors stand back by
  double boxes_per_m = 0.0;     ///< cabinets and bins along each wall
  double people_per_m = 0.0;    ///< standing near each wall, 0.3 m across
  double glass_per_m = 0.0;     ///< panes of 1.5 m that beams pass, on average so many a metre
};

/// A wall from `a_m` to `b_m` with the corridor on its left, furnished; nothing stands farther from
/// it than `depth_m`.
void append_furnished_wall(const Eigen::Vector2d& a_m, const Eigen::Vector2d& b_m, double depth_m,
                           const CorridorFurniture& furniture, Rng& rng,
                           std::vector<Segment>& walls);

struct CorridorsParams {
  std::array<double, 3> lengths_m{30.0, 30.0, 30.0};  ///< of the centre line
  double width_m = 2.4;
  CorridorFurniture furniture{.door_spacing_m = 0.0};
};
/// Along x, then along y, then along x again; closed at both ends.
[[nodiscard]] Result<FloorPlan> three_corridors(const CorridorsParams& params, const Rng& rng);

enum class MotionPattern { straight = 1, curved = 2 };

/// A gyro as Liu 2015, section 6.1, has it, in the class of a Crossbow IMU300CC: a bias that is
/// constant, one that drifts at a constant rate, a first-order Gauss-Markov part, and white noise.
struct CorridorGyro {
  double largest_bias_rad_s = 0.0349;  ///< 2 °/s: the constant part is drawn evenly within
  double drift_rad_s2 = 6e-6;          ///< its sign is drawn
  double walk_sigma_rad_s = 3.5e-5;    ///< of the Gauss-Markov part, 0.002 °/s
  double walk_tau_s = 100.0;
  double angle_random_walk_rad_per_sqrt_s = 6.545e-4;  ///< 2.25 °/√h
  double range_rad_s = 1.745;                          ///< ±100 °/s
};

struct CorridorDriveParams {
  CorridorsParams place;
  MotionPattern pattern = MotionPattern::straight;
  double speed_m_s = 0.3;
  double acceleration_m_s2 = 0.2;
  double corner_radius_m = 1.0;
  double weave_rad = 0.26;      ///< of the curved pattern: largest heading off the corridor's
  double weave_length_m = 4.0;  ///< there and back to the middle
  double rest_s = 120.0;        ///< standing before the drive
  CorridorGyro gyro;
  double speed_scale_sigma = 0.005;   ///< the wheels' scale error is drawn with this
  double slip_m_per_sqrt_m = 0.0005;  ///< random part of the distance rolled
  double latitude_rad = 0.77;         ///< of the Earth's turn the gyro feels; 44.2° north
  Lidar2dParams lidar = lms200();     ///< at the vehicle's centre
  Duration motion_period{50'000'000};
  Duration scan_period{200'000'000};

  /// SICK LMS-200: 361 beams of 0.5° over half a turn, σ 5 mm, 80 m.
  [[nodiscard]] static Lidar2dParams lms200();
};

/// Which part of the drive a time belongs to, as the tables of Liu 2015 divide it.
enum class CorridorSection { corridor_1, corner_1, corridor_2, corner_2, corridor_3 };
[[nodiscard]] std::string_view name_of(CorridorSection section);

struct CorridorDrive {
  FloorPlan plan;
  Recording recording;                  ///< scans, wheels, gyro, truth
  std::vector<double> gyro_bias_rad_s;  ///< of each gyro sample: the truth the filter looks for
  double speed_scale = 0.0;             ///< metres reported per metre rolled, less one
  std::array<LogTime, 4> section_ends;  ///< of all sections but the last

  [[nodiscard]] CorridorSection section_at(LogTime time) const;
};

/// Starts at rest at the origin, along x. Every sensor draws from a stream of its own.
[[nodiscard]] Result<CorridorDrive> simulate_corridors(const CorridorDriveParams& params,
                                                       const Rng& rng);

}  // namespace wayfare::sim
