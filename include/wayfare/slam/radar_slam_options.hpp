#pragma once

// Parameters of RadarSlam: the matching and mapping of each sensor's scans, particles, resampling.

#include <cstddef>
#include <cstdint>
#include <optional>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/frame.hpp>
#include <wayfare/filter/rbpf.hpp>
#include <wayfare/map/inverse_lidar.hpp>
#include <wayfare/map/likelihood_field.hpp>
#include <wayfare/map/occupancy_grid.hpp>
#include <wayfare/match/pose_proposal.hpp>
#include <wayfare/slam/scan_outcome.hpp>

namespace wayfare {

/// Rejects false matches by their correction of the motion (Zhang 2020, 5.3.4): across the robot's
/// heading and in heading. Unlike the largest correction it does not narrow the search, so that a
/// false match is found and rejected rather than replaced by the best within the limits.
struct MatchGate {
  double lateral_m = 1000.0;           ///< by default never
  Angle turn = Angle::degrees(180.0);  ///< by default never
};

/// Parameters of one sensor's scans.
struct RbpfSensorOptions {
  /// Clamped after a few scans, so that a wall survives later scans that conflict with it.
  /// Fine cells: a scan turned against a wall parallel to the grid's axes looks the same until its
  /// points leave their row of cells, so that coarse ones leave the heading open.
  OccupancyGridOptions grid{
      .resolution_m = 0.025, .min_probability = 0.002, .max_probability = 0.999};
  /// Field of each particle's map, in which scans are matched.
  OccupancyFieldOptions field{.sigma_m = 0.03};
  /// If given, scans are matched in the density of detections instead: for a sensor that frees no
  /// cells. One detection counts as much as it did in mapping.
  std::optional<DetectionViewOptions> density{};
  /// Errors of a scan's points are correlated: effective number of points, against the motion and
  /// in the weights; 0: all. Larger: more confidence in the matches, and earlier particle
  /// depletion.
  double independent_points = 0.0;
  /// Scans with fewer points are not matched: the motion model's pose is kept.
  std::size_t min_points = 10;
  /// Agreement with the map in [0, 1] below which a match is rejected.
  double min_score = 0.4;
  /// Agreement below which a wide search follows, around the pose predicted from the best
  /// particle's matches and within these limits, with half the confidence in the motion. Its match
  /// must improve the log likelihood of scan and motion by `wide_margin_nats`. Zero metres: never.
  double tracked_score = 0.65;
  double wide_m = 0.8;                   ///< half width of the wide search
  Angle wide_turn = Angle::degrees(50);  ///< half width of its headings
  double wide_margin_nats = 5.0;         ///< least gain of a wide search
  /// Larger corrections are rejected.
  double max_correction_m = 1.2;
  Angle max_turn_correction = Angle::degrees(60);  ///< of the heading
  MatchGate gate{};  ///< rejects matches by their lateral and heading correction
  /// Half width of the search window in standard deviations of the motion.
  double search_sigmas = 3.0;
  /// Farther points are not matched, m. Those of a radar are not mapped either: each detection, if
  /// only of noise, takes memory where it is.
  double max_range_m = 20.0;
  /// Between neighbouring points, m.
  double point_spacing_m = 0.1;
  /// Travel and heading change since the sensor's last mapped scan after which a scan is added to
  /// the maps. A map of walls extended by every scan accumulates the pose error of each.
  double map_travel_m = 0.2;
  Angle map_turn = Angle::degrees(8);  ///< heading change
  /// Above this number of points, a match is searched with every second point, third, and so on,
  /// and refined with all. Zero: always all.
  std::size_t search_points = 60;
  PathDrift drift{};  ///< of paths by this sensor; of both, that of the LiDAR
  /// Loops are searched and closed as if the drift were this many times larger: it has longer tails
  /// than a Gaussian.
  double drift_margin = 1.0;
  double loop_score = 0.6;     ///< agreement below which a match does not close a loop
  double loop_sigma_m = 0.02;  ///< least standard deviation of such a match
  Angle loop_sigma_turn = Angle::degrees(0.15);  ///< the same of its heading
};

/// For few points, half of them ghosts or clutter, with bearing errors of a degree or two. Only
/// static reflectors persist, so the map counts every scan taken after any motion.
[[nodiscard]] inline RbpfSensorOptions radar_sensor_options() {
  RbpfSensorOptions o;
  o.grid = detection_map();
  o.density = DetectionViewOptions{.max_detections = 30.0};
  o.independent_points = 60.0;
  o.min_points = 15;
  o.min_score = 0.05;
  o.wide_m = 0.0;
  o.max_range_m = 60.0;
  o.point_spacing_m = 0.0;
  o.map_travel_m = 0.05;
  o.search_points = 0;
  o.drift = {0.01, Angle::degrees(0.175)};
  o.drift_margin = 2.0;
  o.loop_score = 0.4;
  o.loop_sigma_m = 0.03;
  o.loop_sigma_turn = Angle::degrees(0.3);
  return o;
}

/// A gyro's bias as a state of every particle, by a Kalman filter given its headings
/// (Rao-Blackwellised, as are the maps): a Gauss-Markov process of the first order.
struct GyroBiasOptions {
  double sigma_rad_s = 0.002;          ///< stationary σ; 0: the gyro has no bias
  double correlation_time_s = 3000.0;  ///< of the process
};

/// Closing of loops: where the robot comes back, the latest scans are matched to a map of the
/// earlier visit alone. A pose graph of the best particle's path distributes the error over the
/// loop; the filter goes on from the smoothed path with its map.
struct LoopSmoothingOptions {
  double gap_m = 12.0;            ///< least path length back to an earlier visit; 0: no smoothing
  double node_distance_m = 0.5;   ///< between nodes of the graph, along the path
  std::size_t nodes_between = 2;  ///< between searches
  double overlap_m = 1.5;         ///< largest distance to a node of the earlier visit, beyond 3 σ
  double largest_reach_m = 3.0;   ///< and at any uncertainty
  double map_radius_m = 5.0;      ///< of the earlier scans that are matched to
  double context_m = 2.0;         ///< of path whose scans are matched together; of the earlier
                                  ///< visit, too, there must be as much
  std::size_t points = 400;       ///< most that are matched
  double prior_scale = 1.5;       ///< of the path's uncertainty, in the search
  double agreement_sigmas = 4.0;  ///< matches of both sensors that differ by more are not used
  double kernel_sigmas = 2.0;     ///< of the loops' Cauchy kernel
  double least_m = 0.03;          ///< smaller corrections do not move the path
  Angle least_turn = Angle::degrees(0.15);  ///< nor do those of the heading
};

/// Particles, sensors and updates of a RadarSlam.
struct RadarSlamOptions {
  std::size_t particles = 30;  ///< at least 1
  std::uint64_t seed = 1;      ///< of all draws
  int threads = 1;  ///< particles processed in parallel; any number gives the same result

  Transform2<frame::Base, frame::Laser> T_base_laser{};  ///< mounting of the laser
  RbpfSensorOptions lidar{};                             ///< of LiDAR scans
  RbpfSensorOptions radar = radar_sensor_options();      ///< of augmented radar scans
  /// Beams that graze a wall free it; a hit outweighs several of them.
  InverseLidarModel lidar_model{.p_free = 0.4, .p_hit = 0.8};
  /// Occupancy that a single radar detection gives its cell; no cell is freed, since radar sees
  /// through objects. Small, because an augmented scan holds many frames of the same reflector: a
  /// cell must be detected repeatedly before it counts.
  double radar_hit_probability = 0.52;

  /// Travel, heading change and time since the sensor's last update after which a scan updates the
  /// filter; scans in between get the predicted pose.
  double update_travel_m = 0.02;
  Angle update_turn = Angle::degrees(0.5);  ///< heading change
  double update_time_s = 5.0;               ///< longest time between updates
  /// Match LiDAR scans in between to the best particle's map, which gives their poses and detects
  /// motion that the motion model missed.
  bool match_skipped = false;

  GyroBiasOptions gyro_bias{};   ///< of motion with a gyro's share
  LoopSmoothingOptions loops{};  ///< closing of loops

  /// Sampling of a particle's pose at its match.
  PoseProposalOptions proposal{.samples = 500, .headings = 20, .divide_by_proposal = true};
  double resample_below = 0.5;  ///< threshold of 1/Σw², as a share of the number of particles
  bool keep_paths = false;      ///< the paths of all particles are part of a RadarSlamRun
};

}  // namespace wayfare
