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

/// Where one set of particles says the robot is.
struct PoseBelief {
  Gaussian<SE2d> pose;  ///< of the heaviest cluster
  double mass = 0.0;    ///< in it
  std::size_t clusters = 0;
  bool converged = false;
};

/// One set of particles and its own course of belief.
class PoseFilter {
 public:
  PoseFilter(std::shared_ptr<const LocalisationMap> map, const LocalisationOptions& options,
             Rng rng)
      : map_(std::move(map)), options_(options), rng_(rng) {}

  void start_at(const Gaussian<SE2d>& pose);
  /// Draws particles from all over the map by how they fit the scan. The ln of what the scan says
  /// of poses anywhere.
  double start_anywhere(const ScanWeigher& scan);

  void move(const Gaussian<SE2d>& motion);
  /// By the map's sharp fields once converged, by the broad ones before. A scan that no particle
  /// can have seen says nothing: the weights stay.
  void weigh(const ScanWeigher& scan);
  /// ln of what the scan says of the particles as they are weighed now; -inf where none of them
  /// can have seen it.
  [[nodiscard]] double log_evidence(const ScanWeigher& scan, bool broad) const;
  /// Puts as many particles again somewhere about: for a set that lost its way by a little.
  void scatter();
  void resample_if_due();
  /// Makes up its mind; to be called once a scan.
  const PoseBelief& believe();

  [[nodiscard]] const PoseBelief& belief() const { return belief_; }
  [[nodiscard]] const ParticleSet& particles() const { return particles_; }

 private:
  [[nodiscard]] Rng next_stream() { return rng_.stream(streams_++); }

  std::shared_ptr<const LocalisationMap> map_;
  LocalisationOptions options_;
  Rng rng_;
  std::uint64_t streams_ = 0;
  ParticleSet particles_;
  PoseBelief belief_;
};

/// The odds of the first set against the second after a scan of which they say `first` and
/// `second`, by log_evidence. A scan impossible for both says nothing; finite whatever they say.
[[nodiscard]] double log_odds_after(double log_odds, double first, double second);

}  // namespace wayfare
