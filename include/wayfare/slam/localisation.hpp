#pragma once

// A known map prepared for localisation: likelihood fields of end points, ray casting, and the free
// cells.
//
// Monte-Carlo localisation on a known map (Dellaert et al. 1999): takes scans and odometry, gives
// the robot's pose, its covariance and whether the filter has converged. Scans are from a LiDAR,
// from a radar on a map of radar detections, or both: along a smooth corridor LiDAR cannot
// distinguish positions, where radar sees the metal in the walls.
//
// Particles move by odometry and are weighted by the likelihood of each scan in the map; their
// number adapts to their spread (KLD sampling, Fox 2003). When recent scans fit badly, a second set
// is drawn over the whole map; it takes over once the evidence says that the robot was kidnapped.

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <wayfare/core/detail/owned.hpp>
#include <wayfare/core/gaussian.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/filter/particles.hpp>
#include <wayfare/map/distance_field.hpp>
#include <wayfare/map/likelihood_field.hpp>
#include <wayfare/map/occupancy_grid.hpp>
#include <wayfare/motion/odometry_model.hpp>
#include <wayfare/sensors/point_set.hpp>
#include <wayfare/sensors/recording.hpp>
#include <wayfare/slam/monte_carlo.hpp>

namespace wayfare {

/// The sensor of a scan.
enum class RangeSensor : std::uint8_t {
  lidar,  ///< laser range finder
  radar,  ///< millimetre-wave radar
};

/// Distribution of a sensor's points around the mapped surfaces.
struct FieldShape {
  /// Standard deviation, m: while tracking, and during a search, when particles are sparser.
  double sigma_m = 0.08;
  double search_sigma_m = 0.25;  ///< during a search
  /// Likelihood of an outlier relative to a point that fits: larger tolerates more outliers.
  double floor_probability = 0.05;
};

/// How a grid becomes a LocalisationMap.
struct LocalisationMapOptions {
  double occupied_probability = 0.65;  ///< least occupancy of a wall
  double free_probability = 0.35;      ///< greatest occupancy of a free cell
  double clearance_m = 0.1;            ///< least distance of the robot's position to walls
  FieldShape lidar{};                  ///< of a LiDAR's end points
  /// Half of a radar's points are clutter, and its bearing error is a degree or two.
  FieldShape radar{0.08, 0.20, 0.2};
  double seen_probability = 0.9;  ///< least occupancy of a reflector in the radar map
};

/// The prepared map. Immutable; shared by localisers and threads.
class LocalisationMap {
 public:
  /// From a grid of the walls and, optionally, a grid of radar detections (of radar_slam, or made
  /// by counting them). Returns an Error if a grid is empty or too large, or has no wall or no free
  /// cell.
  [[nodiscard]] static Result<std::shared_ptr<const LocalisationMap>> make(
      const OccupancyGrid& grid, const LocalisationMapOptions& options = {},
      const OccupancyGrid* radar = nullptr);

  /// As given.
  [[nodiscard]] const LocalisationMapOptions& options() const { return options_; }
  /// Side of a cell, m.
  [[nodiscard]] double resolution_m() const { return fields_[0].sharp.resolution_m(); }
  /// Whether there are fields of that sensor.
  [[nodiscard]] bool has(RangeSensor sensor) const { return !fields(sensor).sharp.empty(); }
  /// ln p of a point, with sigma_m and with search_sigma_m.
  struct Fields {
    LikelihoodField sharp,  ///< with sigma_m
        broad;              ///< with search_sigma_m
  };
  /// Fields of one sensor; without cells where has() is false.
  [[nodiscard]] const Fields& fields(RangeSensor sensor) const {
    return fields_[static_cast<std::size_t>(sensor)];
  }
  /// Expected ranges among the walls.
  [[nodiscard]] const RayCaster& rays() const { return rays_; }
  /// Cells in which the robot's position may lie.
  [[nodiscard]] const std::vector<Cell>& free_cells() const { return free_cells_; }
  /// Area of free_cells().
  [[nodiscard]] double free_area_m2() const {
    return resolution_m() * resolution_m() * static_cast<double>(free_cells_.size());
  }
  /// A position anywhere in the free cells, at any heading.
  [[nodiscard]] SE2d random_pose(Rng& rng) const;

 private:
  LocalisationMapOptions options_;
  std::array<Fields, 2> fields_;
  RayCaster rays_;
  std::vector<Cell> free_cells_;
};

/// Likelihood model of a scan. Models of your own: basic_localiser.hpp.
enum class ScanLikelihood {
  likelihood_field,  ///< distance of each end point to a wall: smooth, fast, ignores occlusion
  beam,              ///< expected range of each beam: uses free space and missing returns too
};

/// Densities of the beam model (Thrun, Burgard and Fox 2005, 6.3), relative to that of a beam with
/// exactly the expected range.
struct BeamModel {
  double p_short = 0.15;    ///< ends before the wall: an unmapped object
  double p_through = 0.03;  ///< ends behind it
  double p_missed = 0.10;   ///< no return from a wall within range
};

/// Weighting of radar scans, each of many frames.
struct RadarWeighing {
  int points = 128;     ///< points of a scan that are used
  int min_points = 15;  ///< a scan with fewer is not used
  /// A radar sees the same reflector again and again: effective number of independent points of a
  /// scan, and the (smaller) one until the filter has converged.
  double independent_points = 16.0;
  double independent_unconverged = 8.0;  ///< until the filter has converged
  /// Frames of a recording that make one scan, and the longest time they may span.
  std::size_t frames = 20;
  double longest_s = 1.5;  ///< their longest duration
};

/// Particles, motion, sensors and likelihoods of a Localiser.
struct LocalisationOptions : MonteCarloOptions, OdometryNoise {
  Transform2<frame::Base, frame::Laser> T_base_laser{};  ///< mounting of the laser
  RadarWeighing radar{};                                 ///< of radar scans
  /// Sensors of a recording that are used; radar only if the map has radar detections.
  bool use_lidar = true,  ///< LiDAR scans
      use_radar = true;   ///< radar scans

  // Scans.
  ScanLikelihood model = ScanLikelihood::likelihood_field;  ///< likelihood of a LiDAR scan
  BeamModel beam{};                                         ///< of ScanLikelihood::beam
  int beams = 64;             ///< beams of a scan that are used, evenly spread; more: slower, surer
  int min_beams = 12;         ///< a scan with fewer returns is not used
  double max_range_m = 30.0;  ///< farther returns are left out
  /// Errors of neighbouring beams are correlated: effective number of independent beams.
  double independent_beams = 16.0;
  double independent_unconverged = 8.0;  ///< the same until the filter has converged
};

/// Result of one scan.
struct LocalisationOutcome : MonteCarloOutcome<SE2d> {
  RangeSensor sensor = RangeSensor::lidar;  ///< of the scan
};

/// One particle, of weight in [0, 1].
using PoseParticle = PoseParticleOf<SE2d>;

/// BasicLocaliser with the likelihoods of this page: for LiDAR and radar scans on LocalisationMap.
/// Processes one scan at a time. Not thread-safe; the same map, options, seed and input give the
/// same bytes for any number of threads.
class Localiser {
 public:
  /// In the state of start_anywhere. The map must not be null.
  Localiser(std::shared_ptr<const LocalisationMap> map, const LocalisationOptions& options,
            std::uint64_t seed);

  /// Draws the particles around a pose. Returns an Error if the pose is not finite or the
  /// covariance not positive semi-definite.
  Result<void> start_at(const Gaussian<SE2d>& T_map_base);
  /// Global localisation: the next scan with enough beams is searched for in the whole map. This is
  /// also the initial state.
  void start_anywhere();

  /// Moves the particles by the odometry up to `time`, without a scan. For long gaps between scans:
  /// the noise then grows with the path driven rather than with the displacement. Returns an Error
  /// for a time not later than the last.
  Result<void> add_motion(LogTime time,
                          const std::optional<Transform2<frame::Odom, frame::Base>>& odometry);

  /// Processes the next scan with the odometry at its time, if any. Returns an Error and changes
  /// nothing for a scan with non-finite geometry or one not later than the last.
  Result<LocalisationOutcome> add_scan(
      const LaserScan& scan, const std::optional<Transform2<frame::Odom, frame::Base>>& odometry);

  /// The same for radar detections in the base frame at `time`, which is not earlier than the last
  /// scan. Returns an Error for points that are not finite, or a map without radar detections.
  Result<LocalisationOutcome> add_radar(
      LogTime time, const PointSet& points_base,
      const std::optional<Transform2<frame::Odom, frame::Base>>& odometry);

  /// Empty before the first scan that is used.
  [[nodiscard]] std::vector<PoseParticle> particles() const;

 private:
  class Engine;
  detail::Owned<Engine> engine_;
};

namespace detail {

template <class Set>
[[nodiscard]] std::vector<PoseParticle> weighted_poses(const Set& particles) {
  const std::vector<double> weights = normalised_weights(particles.log_weights);
  std::vector<PoseParticle> result;
  result.reserve(particles.size());
  for (std::size_t i = 0; i < particles.size(); ++i)
    result.push_back({particles.state(i), weights[i]});
  return result;
}

}  // namespace detail

/// The particles at a time.
struct ParticleSnapshot {
  LogTime time;                         ///< of the scan
  std::vector<PoseParticle> particles;  ///< after it
};

/// Results for a whole recording.
struct LocalisationRun {
  std::vector<LocalisationOutcome> outcomes;  ///< one per time: of two scans at one time the later
  std::vector<ParticleSnapshot> snapshots;    ///< those requested
  std::size_t refused_scans = 0;              ///< by add_scan and add_radar
  std::string first_refusal;                  ///< reason for the first of them

  /// The poses, each at its scan's time; of converged outcomes only, if requested.
  [[nodiscard]] Trajectory trajectory(bool converged_only = false) const;
};

/// Of a run by a localiser of type `L`.
template <class L>
struct LocalisationControlOf {
  /// Called with the fraction done; return false to stop and keep the results so far.
  std::function<bool(double fraction)> progress = {};
  /// Called before each scan; may set the particles through `localiser`.
  std::function<void(std::size_t scan, L& localiser)> before_scan = {};
  /// Fractions of the scans at which snapshots are kept.
  std::vector<double> snapshots_at = {};
};
using LocalisationControl = LocalisationControlOf<Localiser>;  ///< of the library's localiser

/// Localises a whole recording, with odometry interpolated at the scans' times and radar frames
/// combined into scans by it. Starts from `start`, or globally. Returns an Error if no scan could
/// be used. By a localiser of your own: run_localisation.hpp.
Result<LocalisationRun> run_localisation(const Recording& recording,
                                         std::shared_ptr<const LocalisationMap> map,
                                         LocalisationOptions options, std::uint64_t seed,
                                         const std::optional<Gaussian<SE2d>>& start = {},
                                         const LocalisationControl& control = {});

}  // namespace wayfare
