#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include <wayfare/core/gaussian.hpp>
#include <wayfare/core/random.hpp>
#include <wayfare/filter/particle_filter.hpp>
#include <wayfare/motion/odometry_model.hpp>
#include <wayfare/slam/detail/pose_measures.hpp>
#include <wayfare/slam/monte_carlo.hpp>

namespace wayfare::detail {

/// Pose estimate of one set of particles.
template <class Pose>
struct PoseEstimate {
  Gaussian<Pose> pose;  ///< of the heaviest cluster
  double mass = 0.0;    ///< weight in that cluster
  std::size_t clusters = 0;
  bool converged = false;
};

/// Number of poses of a search, within the limits of the options. `wanted` that is NaN gives the
/// least.
[[nodiscard]] inline std::size_t candidate_count(double wanted, const MonteCarloOptions& options) {
  const double most = static_cast<double>(std::max<std::size_t>(options.max_candidates, 1));
  const double least = std::min(static_cast<double>(options.min_candidates), most);
  return static_cast<std::size_t>(std::min(std::max({1.0, least, wanted}), most));
}

/// Poses spread over the whole map.
template <class Set, class Map>
[[nodiscard]] Set poses_anywhere(const Map& map, const MonteCarloOptions& options, const Rng& rng) {
  if constexpr (requires { Set::anywhere(map, options, rng); }) {
    return Set::anywhere(map, options, rng);
  } else {
    double wanted = 0.0;
    if constexpr (requires { map.free_area_m2(); })
      wanted = options.candidates_per_m2 * map.free_area_m2();
    return draw_particles(
        candidate_count(wanted, options), [&](Rng& own) { return map.random_pose(own); }, rng,
        options.threads);
  }
}

template <class Set, class Bins>
[[nodiscard]] typename Bins::Key key_of(const Set& particles, std::size_t i, const Bins& bins) {
  if constexpr (requires { particles.key(i, bins); })
    return particles.key(i, bins);
  else
    return bins(particles.state(i));
}

/// `count` draws by weight, each with normal noise: separates copies of one particle.
template <class Set>
[[nodiscard]] Set resample_with_noise(const Set& from, std::size_t count, double sigma_m,
                                      double sigma_rad, Rng& rng) {
  Set drawn;
  for (const ParticleIndex i : resample(from.log_weights, count, Resampling::low_variance, rng)) {
    if constexpr (requires { from.with_noise(i, sigma_m, sigma_rad, rng); })
      drawn.push_back(from.with_noise(i, sigma_m, sigma_rad, rng));
    else
      drawn.push_back(with_noise(from.state(i), sigma_m, sigma_rad, rng));
  }
  return drawn;
}

template <class Set, class Bins>
[[nodiscard]] std::vector<Cluster> clusters_of(const Set& particles,
                                               std::span<const double> weights, const Bins& bins) {
  std::vector<typename Bins::Key> keys(particles.size());
  for (std::size_t i = 0; i < keys.size(); ++i) keys[i] = key_of(particles, i, bins);
  return find_clusters(keys, weights, bins);
}

/// One set of particles and its estimate. A scan has `weigh(map, broad, particles, result)`, which
/// sets ln p of each particle, and optionally `weigh_candidates(map, particles, result)`.
template <class Set, class Map>
class PoseFilter {
 public:
  using Pose = typename Set::Value;
  using Bins = typename PoseBinsOf<Pose>::Type;

  PoseFilter(std::shared_ptr<const Map> map, const MonteCarloOptions& options, Rng rng)
      : map_(std::move(map)), options_(options), rng_(rng) {}

  void start_at(const Gaussian<Pose>& pose) {
    particles_.resize(std::max(options_.min_particles, options_.max_particles / 4));
    for (std::size_t i = 0; i < particles_.size(); ++i) particles_.set(i, Pose::identity());
    move(motion_sampler<Pose>(pose));
  }
  /// Draws particles over the whole map by their likelihood. Returns ln of the scan's evidence for
  /// poses anywhere.
  template <class Scan>
  double start_anywhere(const Scan& scan) {
    Set candidates = poses_anywhere<Set>(*map_, options_, next_stream());
    if constexpr (requires { scan.weigh_candidates(*map_, candidates, candidates.log_weights); })
      scan.weigh_candidates(*map_, candidates, candidates.log_weights);
    else
      scan.weigh(*map_, true, candidates, candidates.log_weights);
    Rng rng = next_stream();
    particles_ =
        resample_with_noise(candidates, std::max(options_.max_particles, options_.min_particles),
                            kSpread_m, kSpread_rad, rng);
    return log_sum_exp(candidates.log_weights) - std::log(static_cast<double>(candidates.size()));
  }

  template <class Sampler>
  void move(const Sampler& sampler) {
    propagate(particles_, sampler, next_stream(), options_.threads);
  }
  /// Less broadly once converged. A scan that is impossible for every particle leaves the weights
  /// unchanged. Returns the number of likelihoods that were NaN or +inf.
  template <class Scan>
  std::size_t weigh(const Scan& scan) {
    return reweight_by(particles_, likelihoods(scan, !estimate_.converged)).refused;
  }
  /// ln of the scan's evidence for the particles at their current weights; -inf if it is impossible
  /// for all of them.
  template <class Scan>
  [[nodiscard]] double log_evidence(const Scan& scan, bool broad) const {
    std::vector<double> joint = likelihoods(scan, broad);
    for (std::size_t i = 0; i < joint.size(); ++i) joint[i] += particles_.log_weights[i];
    return log_sum_exp(joint) - log_sum_exp(particles_.log_weights);
  }
  /// Adds as many particles with noise: for a set that is slightly off. Nothing while the set is
  /// above its limit: where the scan fits nowhere, no resampling follows.
  void add_noisy_copies() {
    if (particles_.size() > std::max(options_.max_particles, options_.min_particles)) return;
    constexpr double kAside_m = 0.2, kAside_rad = 0.1;
    Rng rng = next_stream();
    const std::size_t n = particles_.size();
    Set aside = resample_with_noise(particles_, n, kAside_m, kAside_rad, rng);
    for (const ParticleIndex i : resample(particles_.log_weights, n, Resampling::low_variance, rng))
      aside.push_back(particles_.state(i));
    particles_ = std::move(aside);
  }

  void resample_if_due() {
    const double effective = effective_sample_size(particles_.log_weights);
    if (effective >= 0.5 * static_cast<double>(particles_.size())) return;
    Rng rng = next_stream();
    const auto key = [&, bins = bins()](std::size_t i) { return key_of(particles_, i, bins); };
    const KldSampling kld{options_.kld_error, options_.kld_quantile,
                          estimate_.converged ? options_.min_particles : options_.min_unconverged,
                          std::max(options_.max_particles, options_.min_particles)};
    particles_ = select(particles_, resample_adaptively(particles_.log_weights, key, kld, rng));
  }

  /// Updates the estimate; call it once per scan.
  const PoseEstimate<Pose>& update_estimate() {
    if (particles_.empty()) return estimate_;
    const std::vector<double> weights = normalised_weights(particles_.log_weights);
    const std::vector<Cluster> clusters = clusters_of(particles_, weights, bins());
    const bool before = estimate_.converged;
    estimate_.mass = clusters.front().mass;
    estimate_.clusters = static_cast<std::size_t>(std::count_if(
        clusters.begin(), clusters.end(), [](const Cluster& c) { return c.mass >= 0.01; }));
    const auto& members = clusters.front().members;
    estimate_.pose.mean = mean_pose(particles_, weights, members);
    estimate_.pose.covariance = covariance_about(estimate_.pose.mean, particles_, weights, members);
    constexpr int kPlace = kPlaceDof<Pose>;
    const double sigma_m =
        std::sqrt(estimate_.pose.covariance.template topLeftCorner<kPlace, kPlace>().trace());
    // Hysteresis: convergence is lost only when most of the weight is elsewhere.
    estimate_.converged = estimate_.mass >= (before ? 0.5 : options_.converged_mass) &&
                          sigma_m <= (before ? 2.0 : 1.0) * options_.converged_sigma_m;
    return estimate_;
  }

  [[nodiscard]] const PoseEstimate<Pose>& estimate() const { return estimate_; }
  [[nodiscard]] const Set& particles() const { return particles_; }

 private:
  static constexpr double kSpread_m = 0.08, kSpread_rad = 0.05;  // the spacing of the candidates

  [[nodiscard]] Rng next_stream() { return rng_.stream(streams_++); }
  [[nodiscard]] Bins bins() const { return {options_.bin_m, options_.bin_turn}; }

  template <class Scan>
  [[nodiscard]] std::vector<double> likelihoods(const Scan& scan, bool broad) const {
    std::vector<double> result(particles_.size());
    scan.weigh(*map_, broad, particles_, result);
    return result;
  }

  std::shared_ptr<const Map> map_;
  MonteCarloOptions options_;
  Rng rng_;
  std::uint64_t streams_ = 0;
  Set particles_;
  PoseEstimate<Pose> estimate_;
};

/// Log odds of the first set against the second after a scan of log evidence `first` and `second`.
/// A scan that is impossible for both leaves them unchanged. Always finite.
[[nodiscard]] inline double log_odds_after(double log_odds, double first, double second) {
  constexpr double kMost = std::numeric_limits<double>::max();
  const double odds = log_odds + (first - second);
  return std::isnan(odds) ? log_odds : std::clamp(odds, -kMost, kMost);
}

}  // namespace wayfare::detail
