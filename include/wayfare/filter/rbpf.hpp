#pragma once

// A Rao-Blackwellised particle filter for mapping (Doucet et al. 2000; Grisetti et al. 2007): each
// particle is a hypothesis of the whole trajectory, with the map that follows from it. The caller
// defines the map, scan matching and map updates.

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include <wayfare/core/contract.hpp>
#include <wayfare/core/finite.hpp>
#include <wayfare/core/random.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/filter/detail/ancestry_tree.hpp>
#include <wayfare/filter/particles.hpp>

namespace wayfare {

/// One hypothesis. Maps of resampled particles are copied: copies should share their common parts,
/// as OccupancyGrid does.
template <class Map, class Pose = SE2d>
struct RbpfParticle {
  Pose pose;  ///< the newest of the trajectory
  Map map;    ///< that follows from the trajectory
  /// ln of the evidence of all measurements along this trajectory; selects the best particle. -inf
  /// without weight.
  double log_evidence = 0.0;
};

/// Calls f(index, worker) for every index in order, on the calling thread.
struct SequentialFor {
  /// f(0, 0) … f(n − 1, 0).
  template <class F>
  void operator()(std::size_t n, const F& f) const {
    for (std::size_t i = 0; i < n; ++i) f(i, std::size_t{0});
  }
};

/// Every particle uses its own random stream at every update, so that the result does not depend on
/// the number of workers. A pose is any manifold.
template <std::copyable Map, Manifold Pose = SE2d>
class Rbpf {
 public:
  using Particle = RbpfParticle<Map, Pose>;  ///< a hypothesis

  /// `count` particles that all start at `start`.
  Rbpf(std::size_t count, const Stamped<Pose>& start, const Map& map, std::uint64_t seed)
      : rng_(seed),
        particles_(count, Particle{start.T_map_base.raw(), map}),
        log_weights_(count, -std::log(static_cast<double>(count))) {
    WAYFARE_EXPECTS(count > 0, "the number of particles must be positive");
    for (std::size_t i = 0; i < count; ++i) ends_.push_back(tree_.add_root(start));
  }

  /// `step(particle, rng, worker)` moves a particle to `time`, applies the measurement and returns
  /// ln of its weight factor. `for_each(count, f)` calls f(index, worker) for every index, on any
  /// number of threads.
  ///
  /// A factor of -inf means that the measurement is impossible for the particle. A factor of NaN or
  /// +inf, or a pose that is not finite, is refused and counted. Both set the weight to zero: the
  /// particle is neither the best nor resampled from, whatever its later factors, and the next
  /// resampling replaces it.
  ///
  /// Error (numerical) if no particle would keep any weight. The particles then are at the poses of
  /// their steps, with the weights and evidence from before this update.
  template <class Step, class ForEach = SequentialFor>
  Result<Normalisation> update(LogTime time, const Step& step, const ForEach& for_each = {}) {
    const Rng of_update = rng_.stream(++updates_);
    std::vector<double> factors(particles_.size());
    for_each(particles_.size(), [&](std::size_t i, std::size_t worker) {
      Rng rng = of_update.stream(i);
      const double factor = step(particles_[i], rng, worker);
      factors[i] =
          has_finite_value(particles_[i].pose) ? factor : std::numeric_limits<double>::quiet_NaN();
    });
    for (std::size_t i = 0; i < particles_.size(); ++i)
      ends_[i] = tree_.append(ends_[i],
                              {time, Transform<frame::Map, frame::Base, Pose>(particles_[i].pose)});
    return weigh(factors);
  }

  /// 1 / Σ w².
  [[nodiscard]] double effective_particles() const { return effective_sample_size(log_weights_); }

  /// Resamples where 1/Σw² is below `fraction` of the number of particles. Particles without weight
  /// are not drawn.
  bool resample_below(double fraction = 0.5) {
    const auto n = static_cast<double>(particles_.size());
    if (!(effective_particles() < fraction * n)) return false;
    Rng rng = rng_.stream(++updates_);
    replace_particles(resample(log_weights_, particles_.size(), Resampling::low_variance, rng));
    std::fill(log_weights_.begin(), log_weights_.end(), -std::log(n));
    return true;
  }

  /// All hypotheses, in the order of log_weights().
  [[nodiscard]] std::span<const Particle> particles() const { return particles_; }
  /// Normalised; -inf without weight.
  [[nodiscard]] std::span<const double> log_weights() const { return log_weights_; }
  /// The particle with weight whose trajectory has the largest evidence.
  [[nodiscard]] std::size_t best() const {
    const auto less = [](const Particle& a, const Particle& b) {
      return a.log_evidence < b.log_evidence;
    };
    return static_cast<std::size_t>(std::max_element(particles_.begin(), particles_.end(), less) -
                                    particles_.begin());
  }
  /// Start pose and one pose per update.
  [[nodiscard]] TrajectoryOf<Pose> trajectory(std::size_t particle) const {
    return tree_.trajectory(ends_[particle]);
  }
  /// Number of poses stored for all trajectories.
  [[nodiscard]] std::size_t stored_poses() const { return tree_.size(); }

 private:
  using Tree = AncestryTreeOf<Pose>;
  using Node = typename Tree::Node;

  Result<Normalisation> weigh(std::span<const double> log_factors) {
    std::vector<double> weights = log_weights_;
    for (std::size_t i = 0; i < weights.size(); ++i) weights[i] += log_factors[i];
    const Normalisation result = normalise(weights);
    if (result.collapsed)
      return Error{ErrorCode::numerical, "Rbpf: the measurement leaves no particle any weight"};
    constexpr double kNone = -std::numeric_limits<double>::infinity();
    constexpr double kMax = std::numeric_limits<double>::max();
    for (std::size_t i = 0; i < weights.size(); ++i) {
      double& evidence = particles_[i].log_evidence;
      // Within the range: -inf is reserved for particles without weight.
      evidence = weights[i] == kNone ? kNone : std::clamp(evidence + log_factors[i], -kMax, kMax);
    }
    log_weights_ = std::move(weights);
    return result;
  }

  /// `drawn` is in ascending order. A particle is moved to its last index and copied to the others.
  void replace_particles(const std::vector<ParticleIndex>& drawn) {
    for (const ParticleIndex i : drawn) tree_.retain(ends_[i]);
    std::vector<Node> ends;
    std::vector<Particle> particles;
    particles.reserve(drawn.size());
    for (std::size_t k = 0; k < drawn.size(); ++k) {
      Particle& from = particles_[drawn[k]];
      const bool last = k + 1 == drawn.size() || drawn[k + 1] != drawn[k];
      ends.push_back(ends_[drawn[k]]);
      particles.push_back(last ? std::move(from) : Particle(from));
    }
    for (const Node end : ends_) tree_.release(end);
    ends_ = std::move(ends);
    particles_ = std::move(particles);
  }

  Rng rng_;
  std::uint64_t updates_ = 0;
  std::vector<Particle> particles_;
  std::vector<double> log_weights_;
  Tree tree_;
  std::vector<Node> ends_;
};

}  // namespace wayfare
