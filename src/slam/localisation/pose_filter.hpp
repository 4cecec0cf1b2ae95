#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include <wayfare/core/gaussian.hpp>
#include <wayfare/core/random.hpp>
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

  void start_at(const Gaussian<SE2d>& pose);
  /// Draws particles over the whole map by their likelihood. Returns ln of the scan's evidence for
  /// poses anywhere.
  double start_anywhere(const ScanWeigher& scan);

  void move(const Gaussian<SE2d>& motion);
  /// With the map's sharp fields once converged, with the broad ones before. A scan that is
  /// impossible for every particle leaves the weights unchanged.
  void weigh(const ScanWeigher& scan);
  /// ln of the scan's evidence for the particles at their current weights; -inf if it is impossible
  /// for all of them.
  [[nodiscard]] double log_evidence(const ScanWeigher& scan, bool broad) const;
  /// Adds as many particles with noise: for a set that is slightly off.
  void add_noisy_copies();
  void resample_if_due();
  /// Updates the estimate; call it once per scan.
  const PoseEstimate& update_estimate();

  [[nodiscard]] const PoseEstimate& estimate() const { return estimate_; }
  [[nodiscard]] const ParticleSet& particles() const { return particles_; }

 private:
  [[nodiscard]] Rng next_stream() { return rng_.stream(streams_++); }

  std::shared_ptr<const LocalisationMap> map_;
  LocalisationOptions options_;
  Rng rng_;
  std::uint64_t streams_ = 0;
  ParticleSet particles_;
  PoseEstimate estimate_;
};

/// Log odds of the first set against the second after a scan of log evidence `first` and `second`.
/// A scan that is impossible for both leaves them unchanged. Always finite.
[[nodiscard]] double log_odds_after(double log_odds, double first, double second);

}  // namespace wayfare
