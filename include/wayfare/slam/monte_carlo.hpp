#pragma once

// Options and results of Monte-Carlo localisation, whatever the likelihood, the model of odometry
// and the map.

#include <cstddef>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/detail/eigen_alignment.hpp>
#include <wayfare/core/gaussian.hpp>
#include <wayfare/core/time.hpp>

namespace wayfare {

/// Updates, particles, search and convergence of Monte-Carlo localisation.
struct MonteCarloOptions {
  /// Travel, heading change or time after which the next scan is weighted: map errors are the same
  /// for neighbouring scans and must count once.
  double update_travel_m = 0.1;
  Angle update_turn = Angle::degrees(3.0);  ///< heading change
  double update_time_s = 1.0;               ///< longest time between weighted scans

  // Motion.
  double max_speed_m_s = 3.0;  ///< odometry with a higher speed or turn rate is refused
  /// Odometry with a higher one is refused; per second.
  Angle max_turn_rate = Angle::degrees(360.0);

  // Particles.
  std::size_t min_particles = 500;     ///< once converged
  std::size_t min_unconverged = 5000;  ///< until the filter has converged
  std::size_t max_particles = 20000;   ///< however they spread
  double kld_error = 0.05;             ///< bound on the KL distance of the particles' histogram …
  double kld_quantile = 2.326;         ///< … with this quantile of the normal distribution (99 %)
  double bin_m = 0.5;                  ///< bin side of that histogram; also separates clusters
  Angle bin_turn = Angle::degrees(15.0);  ///< its heading extent

  // Search over the whole map.
  double candidates_per_m2 = 600.0;      ///< poses weighted by the scan
  std::size_t min_candidates = 100'000;  ///< on small maps too: similar positions get equal shares
  std::size_t max_candidates = 1'000'000;  ///< on large maps
  double search_ratio = 0.85;      ///< share of the usual agreement below which a search starts …
  int scans_between_searches = 5;  ///< … at most once in this number of scans
  double kidnap_probability =
      0.05;  ///< prior probability of a kidnapped robot when a search starts

  // Convergence.
  double converged_mass = 0.9;     ///< least weight in one cluster …
  double converged_sigma_m = 0.5;  ///< … greatest standard deviation of its position …
  double rejection_ratio = 0.75;   ///< … and least share of the best agreement with the map
  /// Number of independent measurements of a scan, n: where the likelihood has no member
  /// `agreement`, the agreement is the geometric mean of their likelihoods, exp(ln p / n).
  double independent_measurements = 16.0;
  int threads = 1;  ///< any number gives the same result
};

/// Result of one scan.
template <class Pose>
struct MonteCarloOutcome {
  LogTime time;               ///< of the scan
  Gaussian<Pose> T_map_base;  ///< of the heaviest cluster of particles; infinite if there is none
  bool converged = false;     ///< whether the pose is reliable
  double mass = 0.0;          ///< weight in that cluster
  std::size_t clusters = 0;   ///< clusters with at least a hundredth of the weight
  std::size_t particles = 0;  ///< number after the scan
  double agreement = 0.0;     ///< of the scan with the map at the pose, in [0, 1]
  bool weighed = false;       ///< false: too few beams, or too little motion since the last one
  bool odometry_refused = false;  ///< missing, not finite or faster than the robot can move
  bool searched = false;          ///< a search over the whole map started
  bool relocalised = false;  ///< that search found another pose, which replaces the previous one
  /// Particles whose log-likelihood was NaN or +inf: they have no weight.
  std::size_t refused_likelihoods = 0;
};

/// One particle, of weight in [0, 1].
template <class Pose>
struct PoseParticleOf {
  Pose T_map_base;      ///< a hypothesis
  double weight = 0.0;  ///< in [0, 1]
};

}  // namespace wayfare
