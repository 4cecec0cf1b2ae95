#include "slam/localisation/pose_filter.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include <wayfare/filter/particles.hpp>

namespace wayfare {
namespace {

/// Weighted mean and covariance of particles, in the axes of the mean.
Gaussian<SE2d> mean_and_covariance(const ParticleSet& particles, const std::vector<double>& weights,
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

std::vector<double> weights_of(const ParticleSet& particles) {
  std::vector<double> weights = particles.log_weight;
  normalise(weights);
  for (double& w : weights) w = std::exp(w);
  return weights;
}

constexpr double kSpread_m = 0.08, kSpread_rad = 0.05;  // the spacing of the candidates

}  // namespace

void PoseFilter::start_at(const Gaussian<SE2d>& pose) {
  particles_.resize(std::max(options_.min_particles, options_.max_particles / 4));
  for (std::size_t i = 0; i < particles_.size(); ++i) particles_.set(i, SE2d());
  wayfare::move(particles_, pose, options_.threads, next_stream());
}

double PoseFilter::start_anywhere(const ScanWeigher& scan) {
  ParticleSet candidates = uniform_poses(*map_, options_, next_stream());
  scan.weigh_by_field(*map_, true, candidates, candidates.log_weight);
  Rng rng = next_stream();
  particles_ =
      resample_with_noise(candidates, std::max(options_.max_particles, options_.min_particles),
                          kSpread_m, kSpread_rad, rng);
  return log_sum_exp(candidates.log_weight) - std::log(static_cast<double>(candidates.size()));
}

void PoseFilter::move(const Gaussian<SE2d>& motion) {
  wayfare::move(particles_, motion, options_.threads, next_stream());
}

void PoseFilter::weigh(const ScanWeigher& scan) {
  std::vector<double> joint(particles_.size());
  scan.weigh(*map_, !estimate_.converged, particles_, joint);
  for (std::size_t i = 0; i < joint.size(); ++i) joint[i] += particles_.log_weight[i];
  if (!normalise(joint).collapsed) particles_.log_weight = std::move(joint);
}

void PoseFilter::add_noisy_copies() {
  constexpr double kAside_m = 0.2, kAside_rad = 0.1;
  Rng rng = next_stream();
  const std::size_t n = particles_.size();
  ParticleSet aside = resample_with_noise(particles_, n, kAside_m, kAside_rad, rng);
  for (const ParticleIndex i : resample(particles_.log_weight, n, Resampling::low_variance, rng))
    aside.push_back(particles_.pose(i));
  particles_ = std::move(aside);
}

double PoseFilter::log_evidence(const ScanWeigher& scan, bool broad) const {
  std::vector<double> joint(particles_.size());
  scan.weigh(*map_, broad, particles_, joint);
  for (std::size_t i = 0; i < joint.size(); ++i) joint[i] += particles_.log_weight[i];
  return log_sum_exp(joint) - log_sum_exp(particles_.log_weight);
}

void PoseFilter::resample_if_due() {
  const double effective = effective_sample_size(particles_.log_weight);
  if (effective >= 0.5 * static_cast<double>(particles_.size())) return;
  Rng rng = next_stream();
  particles_ = resample_adaptively(
      particles_, {options_.bin_m, options_.bin_turn}, options_,
      estimate_.converged ? options_.min_particles : options_.min_unconverged, rng);
}

const PoseEstimate& PoseFilter::update_estimate() {
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

double log_odds_after(double log_odds, double first, double second) {
  constexpr double kMost = std::numeric_limits<double>::max();
  const double odds = log_odds + (first - second);
  return std::isnan(odds) ? log_odds : std::clamp(odds, -kMost, kMost);
}

}  // namespace wayfare
