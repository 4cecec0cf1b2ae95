#pragma once

// Monte-Carlo localisation on a known map (Dellaert et al. 1999): scans and odometry in, the pose
// of the robot, its covariance and whether it is to be believed out. Scans are a LiDAR's, a radar's
// on a map of what radar sees, or both: along a smooth corridor LiDAR cannot tell one place from
// the next, where radar sees the metal in the walls.
//
// Particles move by odometry and are weighed by how well each scan fits the map; their number
// follows how far they spread (KLD sampling, Fox 2003). Where the scans of late fit badly, a second
// set begins all over the map and takes over once it explains what was seen since so much better
// that the robot must have been carried away.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <wayfare/core/gaussian.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/motion/motion_noise.hpp>
#include <wayfare/sensors/point_set.hpp>
#include <wayfare/sensors/recording.hpp>
#include <wayfare/slam/localisation_map.hpp>

namespace wayfare {

/// How a scan is held against the map.
enum class ScanLikelihood {
  likelihood_field,  ///< how near to a wall each beam ends: smooth, fast, blind to what is between
  beam,  ///< the range each beam should have: knows walls from free space, no returns too
};

/// The densities of the beam model (Thrun, Burgard and Fox 2005, 6.3), against that of a beam that
/// is just as long as it should be.
struct BeamModel {
  double p_short = 0.15;    ///< ends before the wall: somebody stands there
  double p_through = 0.03;  ///< ends behind it
  double p_missed = 0.10;   ///< does not return though there is a wall in reach
};

/// How a radar's scans are weighed, of many frames each.
struct RadarWeighing {
  int points = 128;     ///< of a scan that are looked at
  int min_points = 15;  ///< a scan with fewer says nothing
  /// What a radar sees of one thing comes again and again: a scan counts as so many independent
  /// points, fewer while it is open where the robot is.
  double independent_points = 16.0;
  double independent_undecided = 8.0;
  /// Of the recording's frames that make one scan, and the longest time they may take.
  std::size_t frames = 20;
  double longest_s = 1.5;
};

struct LocalisationOptions {
  Transform2<frame::Base, frame::Laser> T_base_laser{};
  RadarWeighing radar{};
  /// Which of a recording's sensors are listened to; radar where the map knows what it sees.
  bool use_lidar = true, use_radar = true;

  // Scans.
  ScanLikelihood model = ScanLikelihood::likelihood_field;
  BeamModel beam{};
  int beams = 64;             ///< of a scan that are looked at, evenly spread; more: slower, surer
  int min_beams = 12;         ///< a scan with fewer returns says nothing
  double max_range_m = 30.0;  ///< farther returns are left out
  /// Neighbouring beams err together: the beams looked at count as so many independent ones.
  double independent_beams = 16.0;
  double independent_undecided = 8.0;  ///< while it is open where the robot is
  /// A scan is weighed once the robot has gone or turned so far, or so long after the last one:
  /// what the map has wrong is the same in neighbouring scans, and counts once.
  double between_m = 0.1;
  Angle between_turn = Angle::degrees(3.0);
  double between_s = 1.0;

  // Motion.
  MotionNoise odometry{0.01, 0.20, 0.02, Angle::degrees(0.5), 0.20, 0.10};
  /// Where odometry is missing or refused, the robot is expected to go on as it did.
  MotionNoise constant_velocity{0.05, 0.50, 0.05, Angle::degrees(3.0), 0.4, 0.2};
  double max_speed_m_s = 3.0;  ///< odometry that moves faster, or turns so, is refused
  Angle max_turn_rate = Angle::degrees(360.0);  ///< a second

  // Particles.
  std::size_t min_particles = 500;
  std::size_t min_undecided = 5000;  ///< while it is open where the robot is
  std::size_t max_particles = 20000;
  double kld_error = 0.05;      ///< between the particles' histogram and the true one …
  double kld_quantile = 2.326;  ///< … held with this normal quantile (99 %)
  double bin_m = 0.5;           ///< of that histogram; also what parts one cluster from another
  Angle bin_turn = Angle::degrees(15.0);

  // Search over the whole map.
  double candidates_per_m2 = 600.0;      ///< poses weighed by the scan
  std::size_t min_candidates = 100'000;  ///< also of a small map: two places alike get alike many
  std::size_t max_candidates = 1'000'000;
  double suspicion = 0.85;  ///< share of its usual agreement below which a search is made …
  int scans_between_searches = 5;    ///< … but not at every scan
  double kidnap_probability = 0.05;  ///< a scan's prior of having been carried away, once suspected

  // Belief.
  double converged_mass = 0.9;  ///< of the weight in one cluster, for the pose to be believed …
  double converged_sigma_m = 0.5;  ///< … the largest standard deviation of its place …
  double disbelief = 0.75;  ///< … and the least share of what agreement with the map used to be
  int threads = 1;          ///< results are the same for any number
};

/// What became of one scan.
struct LocalisationOutcome {
  LogTime time;
  RangeSensor sensor = RangeSensor::lidar;
  Gaussian<SE2d> T_map_base;  ///< of the heaviest cluster of particles
  bool converged = false;     ///< whether that is where the robot is, as far as one can tell
  double mass = 0.0;          ///< of the weight in that cluster
  std::size_t clusters = 0;   ///< places that hold a hundredth of the weight or more
  std::size_t particles = 0;
  double agreement = 0.0;         ///< of the scan with the map at the pose, in [0, 1]
  bool weighed = false;           ///< false: too few beams, or nothing new; motion stands alone
  bool odometry_refused = false;  ///< missing, not finite or faster than the robot
  bool searched = false;          ///< a search over the whole map began
  bool moved = false;             ///< it found the robot elsewhere, and is believed from here on
};

/// One particle, of weight in [0, 1].
struct PoseParticle {
  SE2d T_map_base;
  double weight = 0.0;
};

/// The localiser, fed scan by scan. Not thread-safe; the same map, options, seed and input give the
/// same bytes for any number of threads.
class Localiser {
 public:
  Localiser(std::shared_ptr<const LocalisationMap> map, const LocalisationOptions& options,
            std::uint64_t seed);
  ~Localiser();
  Localiser(Localiser&&) noexcept;
  Localiser& operator=(Localiser&&) noexcept;

  /// Puts the particles about a pose. An Error where it is not finite or its covariance no
  /// covariance.
  Result<void> start_at(const Gaussian<SE2d>& T_map_base);
  /// Nothing is known: the next scan with enough beams is looked for all over the map. This is also
  /// how a new localiser starts.
  void start_anywhere();

  /// Moves the particles to where odometry says the robot is by `time`, without a scan: for long
  /// gaps between scans, whose noise then grows with the way and not with where it led. Refused
  /// with an Error: a time not later than the last.
  Result<void> add_motion(LogTime time,
                          const std::optional<Transform2<frame::Odom, frame::Base>>& odometry);

  /// Takes the next scan and, where there is any, odometry at its time. Refused with an Error,
  /// changing nothing: a scan with other than finite geometry, one not later than the last.
  Result<LocalisationOutcome> add_scan(
      const LaserScan& scan, const std::optional<Transform2<frame::Odom, frame::Base>>& odometry);

  /// The same with a radar's detections, in the robot's own frame at `time`; not earlier than the
  /// last scan. Refused: points that are not finite, a map that knows nothing of radar.
  Result<LocalisationOutcome> add_radar(
      LogTime time, const PointSet& points_base,
      const std::optional<Transform2<frame::Odom, frame::Base>>& odometry);

  [[nodiscard]] std::vector<PoseParticle> particles() const;

 private:
  class Engine;
  std::unique_ptr<Engine> engine_;
};

/// The particles at one time.
struct ParticleSnapshot {
  LogTime time;
  std::vector<PoseParticle> particles;
};

struct LocalisationRun {
  std::vector<LocalisationOutcome> outcomes;  ///< one a scan taken, of two at a time the later one
  std::vector<ParticleSnapshot> snapshots;    ///< where asked for
  std::size_t refused_scans = 0;
  std::string first_refusal;  ///< why the first of them was

  /// The poses, each at its scan's time; of converged outcomes only, where asked.
  [[nodiscard]] Trajectory trajectory(bool converged_only = false) const;
};

struct LocalisationControl {
  /// Called with the fraction done; return false to stop with what there is so far.
  std::function<bool(double fraction)> progress = {};
  /// Called before each scan: where it gives a pose, the particles are put there.
  std::function<void(std::size_t scan, Localiser& localiser)> before_scan = {};
  /// Snapshots are kept at this fraction of the scans …
  std::vector<double> snapshots_at = {};
};

/// Localises a whole recording (odometry interpolated at the scans' times; a radar's frames
/// gathered by it into scans) from `start`, or from nowhere. An Error where no scan could be used.
Result<LocalisationRun> run_localisation(const Recording& recording,
                                         std::shared_ptr<const LocalisationMap> map,
                                         LocalisationOptions options, std::uint64_t seed,
                                         const std::optional<Gaussian<SE2d>>& start = {},
                                         const LocalisationControl& control = {});

}  // namespace wayfare
