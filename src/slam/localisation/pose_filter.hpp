#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include <wayfare/core/gaussian.hpp>
#include <wayfare/core/random.hpp>
#include <wayfare/filter/particles.hpp>
#include <wayfare/slam/localisation.hpp>

#include "slam/localisation/particle_set.hpp"
#include "slam/localisation/scan_weigher.hpp"

namespace wayfare {

/// Pose estimate of one set of particles.
struct PoseEstimate {
  Gaussian<SE2d> pose;  ///< of the heaviest cluster
  double mass = 0.0;    ///< weight in that cluster
  std::size_t clusters = 0;
  bool converged = false;
};

/// One set of particles and its estimate.
class PoseFilter {
 public:
  PoseFilter(std::shared_ptr<const LocalisationMap> map, const LocalisationOptions& options,
             Rng rng)
      : map_(std::move(map)), options_(options), rng_(rng) {}

  void start_at(const Gaussian<SE2d>& pose) {
    particles_.resize(std::max(options_.min_particles, options_.max_particles / 4));
    for (std::size_t i = 0; i < particles_.size(); ++i) particles_.set(i, SE2d());
    wayfare::move(particles_, pose, options_.threads, next_stream());
  }
  /// Draws particles over the whole map by their likelihood. Returns ln of the scan's evidence for
  /// poses anywhere.
  double start_anywhere(const ScanWeigher& scan) {
    ParticleSet candidates = uniform_poses(*map_, options_, next_stream());
    scan.weigh_by_field(*map_, true, candidates, candidates.log_weight);
    Rng rng = next_stream();
    particles_ =
        resample_with_noise(candidates, std::max(options_.max_particles, options_.min_particles),
                            kSpread_m, kSpread_rad, rng);
    return log_sum_exp(candidates.log_weight) - std::log(static_cast<double>(candidates.size()));
  }

  void move(const Gaussian<SE2d>& motion) {
    wayfare::move(particles_, motion, options_.threads, next_stream());
  }
  /// With the map's sharp fields once converged, with the broad ones before. A scan that is
  /// impossible for every particle leaves the weights unchanged.
  void weigh(const ScanWeigher& scan) {
    std::vector<double> joint = joint_weights(scan, !estimate_.converged);
    if (!normalise(joint).collapsed) particles_.log_weight = std::move(joint);
  }
  /// ln of the scan's evidence for the particles at their current weights; -inf if it is impossible
  /// for all of them.
  [[nodiscard]] double log_evidence(const ScanWeigher& scan, bool broad) const {
    return log_sum_exp(joint_weights(scan, broad)) - log_sum_exp(particles_.log_weight);
  }
  /// Adds as many particles with noise: for a set that is slightly off. Nothing while the set is
  /// above its limit: where the scan fits nowhere, no resampling follows.
  void add_noisy_copies() {
    if (particles_.size() > std::max(options_.max_particles, options_.min_particles)) return;
    constexpr double kAside_m = 0.2, kAside_rad = 0.1;
    Rng rng = next_stream();
    const std::size_t n = particles_.size();
    ParticleSet aside = resample_with_noise(particles_, n, kAside_m, kAside_rad, rng);
    for (const ParticleIndex i : resample(particles_.log_weight, n, Resampling::low_variance, rng))
      aside.push_back(particles_.pose(i));
    particles_ = std::move(aside);
  }

  void resample_if_due() {
    const double effective = effective_sample_size(particles_.log_weight);
    if (effective >= 0.5 * static_cast<double>(particles_.size())) return;
    Rng rng = next_stream();
    particles_ = resample_adaptively(
        particles_, {options_.bin_m, options_.bin_turn}, options_,
        estimate_.converged ? options_.min_particles : options_.min_unconverged, rng);
  }

  /// Updates the estimate; call it once per scan.
  const PoseEstimate& update_estimate() {
    if (particles_.empty()) return estimate_;
    const std::vector<double> weights = weights_of(particles_);
    const std::vector<Cluster> clusters =
        find_clusters(particles_, weights, {options_.bin_m, options_.bin_turn});
    const bool before = estimate_.converged;
    estimate_.mass = clusters.front().mass;
    estimate_.clusters = static_cast<std::size_t>(std::count_if(
        clusters.begin(), clusters.end(), [](const Cluster& c) { return c.mass >= 0.01; }));
    estimate_.pose = mean_and_covariance(particles_, weights, clusters.front().members);
    const double sigma_m = std::sqrt(estimate_.pose.covariance.topLeftCorner<2, 2>().trace());
    // Hysteresis: convergence is lost only when most of the weight is elsewhere.
    estimate_.converged = estimate_.mass >= (before ? 0.5 : options_.converged_mass) &&
                          sigma_m <= (before ? 2.0 : 1.0) * options_.converged_sigma_m;
    return estimate_;
  }

  [[nodiscard]] const PoseEstimate& estimate() const { return estimate_; }
  [[nodiscard]] const ParticleSet& particles() const { return particles_; }

 private:
  static constexpr double kSpread_m = 0.08, kSpread_rad = 0.05;  // the spacing of the candidates

  [[nodiscard]] Rng next_stream() { return rng_.stream(streams_++); }

  /// Weighted mean and covariance of particles, in the axes of the mean.
  static Gaussian<SE2d> mean_and_covariance(const ParticleSet& particles,
                                            const std::vector<double>& weights,
                                            const std::vector<std::uint32_t>& members) {
    double sum = 0.0, c = 0.0, s = 0.0;
    Eigen::Vector2d place = Eigen::Vector2d::Zero();
    for (const std::uint32_t i : members) {
      sum += weights[i];
      place += weights[i] * Eigen::Vector2d(particles.x_m[i], particles.y_m[i]);
      c += weights[i] * std::cos(particles.heading_rad[i]);
      s += weights[i] * std::sin(particles.heading_rad[i]);
    }
    Gaussian<SE2d> result;
    result.mean = SE2d(place.x() / sum, place.y() / sum, Angle::radians(std::atan2(s, c)));
    result.covariance.setZero();
    for (const std::uint32_t i : members) {
      const Eigen::Vector3d off = particles.pose(i).minus(result.mean);
      result.covariance += weights[i] / sum * off * off.transpose();
    }
    return result;
  }

  /// Log weights after the scan, not normalised.
  [[nodiscard]] std::vector<double> joint_weights(const ScanWeigher& scan, bool broad) const {
    std::vector<double> joint(particles_.size());
    scan.weigh(*map_, broad, particles_, joint);
    for (std::size_t i = 0; i < joint.size(); ++i) joint[i] += particles_.log_weight[i];
    return joint;
  }

  std::shared_ptr<const LocalisationMap> map_;
  LocalisationOptions options_;
  Rng rng_;
  std::uint64_t streams_ = 0;
  ParticleSet particles_;
  PoseEstimate estimate_;
};

/// Log odds of the first set against the second after a scan of log evidence `first` and `second`.
/// A scan that is impossible for both leaves them unchanged. Always finite.
[[nodiscard]] inline double log_odds_after(double log_odds, double first, double second) {
  constexpr double kMost = std::numeric_limits<double>::max();
  const double odds = log_odds + (first - second);
  return std::isnan(odds) ? log_odds : std::clamp(odds, -kMost, kMost);
}

}  // namespace wayfare
