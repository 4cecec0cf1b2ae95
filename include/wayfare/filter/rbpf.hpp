#pragma once

// A Rao-Blackwellised particle filter for mapping (Doucet et al. 2000; Grisetti et al. 2007): each
// particle is a hypothesis of the whole way, with the map that follows from it. What a map is, how
// a scan is matched with it and how it takes one up are the caller's.

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
#include <wayfare/core/random.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/filter/detail/ancestry_tree.hpp>
#include <wayfare/filter/particles.hpp>

namespace wayfare {

/// One hypothesis. Maps are copied when particles are drawn twice: they should share what does not
/// differ, as OccupancyGrid does.
template <class Map>
struct RbpfParticle {
  SE2d pose;
  Map map;
  /// ln of the evidence of everything this particle's way has explained; what the best is chosen
  /// by. -inf without weight.
  double log_evidence = 0.0;
};

/// Calls f(index, worker) for every index, one after the other.
struct OneAfterTheOther {
  template <class F>
  void operator()(std::size_t n, const F& f) const {
    for (std::size_t i = 0; i < n; ++i) f(i, std::size_t{0});
  }
};

/// Every particle draws from a random stream of its own at every update, so that the result is the
/// same however many workers share the particles out.
template <std::copyable Map>
class Rbpf {
 public:
  using Particle = RbpfParticle<Map>;

  /// `count` particles that all begin at `start`.
  Rbpf(std::size_t count, const StampedPose& start, const Map& map, std::uint64_t seed)
      : rng_(seed),
        particles_(count, Particle{start.T_map_base.raw(), map}),
        log_weights_(count, -std::log(static_cast<double>(count))) {
    WAYFARE_EXPECTS(count > 0, "a filter needs a particle");
    for (std::size_t i = 0; i < count; ++i) ends_.push_back(tree_.plant(start));
  }

  /// `step(particle, rng, worker)` moves a particle to `time`, takes up what was measured and
  /// returns ln of the factor of its weight. `for_each(count, f)` calls f(index, worker) for every
  /// index, on as many threads as it likes.
  ///
  /// A factor of -inf says that the measurement is impossible for the particle. NaN and +inf are no
  /// factors: the particle is refused, and counted as such, as is one whose pose is not finite.
  /// Both leave it without weight: it is neither the best nor drawn, whatever its later factors,
  /// and the next resampling replaces it.
  ///
  /// An Error (numerical) where no particle would have any weight left. The particles then are
  /// where their steps led, but weights and evidence are those before this update: the measurement
  /// counts for nothing, and particles that had no weight have none.
  template <class Step, class ForEach = OneAfterTheOther>
  Result<Normalisation> update(LogTime time, const Step& step, const ForEach& for_each = {}) {
    const Rng of_update = rng_.stream(++updates_);
    std::vector<double> factors(particles_.size());
    for_each(particles_.size(), [&](std::size_t i, std::size_t worker) {
      Rng rng = of_update.stream(i);
      const double factor = step(particles_[i], rng, worker);
      factors[i] = finite(particles_[i].pose) ? factor : std::numeric_limits<double>::quiet_NaN();
    });
    for (std::size_t i = 0; i < particles_.size(); ++i)
      ends_[i] =
          tree_.grow(ends_[i], {time, Transform2<frame::Map, frame::Base>(particles_[i].pose)});
    return weigh(factors);
  }

  /// 1 / Σ w².
  [[nodiscard]] double effective_particles() const { return effective_sample_size(log_weights_); }

  /// Draws the particles anew, none without weight, where 1/Σw² is below `fraction` of their
  /// number.
  bool resample_below(double fraction = 0.5) {
    const auto n = static_cast<double>(particles_.size());
    if (!(effective_particles() < fraction * n)) return false;
    Rng rng = rng_.stream(++updates_);
    draw_anew(resample(log_weights_, particles_.size(), Resampling::low_variance, rng));
    std::fill(log_weights_.begin(), log_weights_.end(), -std::log(n));
    return true;
  }

  [[nodiscard]] std::span<const Particle> particles() const { return particles_; }
  /// Normalised; -inf without weight.
  [[nodiscard]] std::span<const double> log_weights() const { return log_weights_; }
  /// The particle whose way explains most, of those with weight.
  [[nodiscard]] std::size_t best() const {
    const auto less = [](const Particle& a, const Particle& b) {
      return a.log_evidence < b.log_evidence;
    };
    return static_cast<std::size_t>(std::max_element(particles_.begin(), particles_.end(), less) -
                                    particles_.begin());
  }
  /// A pose for the start and for every update.
  [[nodiscard]] Trajectory way(std::size_t particle) const { return tree_.way(ends_[particle]); }
  /// Poses of all ways together that are kept.
  [[nodiscard]] std::size_t poses_kept() const { return tree_.size(); }

 private:
  [[nodiscard]] static bool finite(const SE2d& pose) {
    return pose.translation().allFinite() && std::isfinite(pose.heading().radians());
  }

  Result<Normalisation> weigh(std::span<const double> log_factors) {
    std::vector<double> weights = log_weights_;
    for (std::size_t i = 0; i < weights.size(); ++i) weights[i] += log_factors[i];
    const Normalisation result = normalise(weights);
    if (result.collapsed)
      return Error{ErrorCode::numerical, "Rbpf: the measurement leaves no particle any weight"};
    constexpr double kNone = -std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < weights.size(); ++i) {
      double& evidence = particles_[i].log_evidence;
      evidence = weights[i] == kNone ? kNone : evidence + log_factors[i];
    }
    log_weights_ = std::move(weights);
    return result;
  }

  /// `drawn` is in ascending order. A particle drawn is moved to its last place and copied to the
  /// others.
  void draw_anew(const std::vector<ParticleIndex>& drawn) {
    for (const ParticleIndex i : drawn) tree_.hold(ends_[i]);
    std::vector<AncestryTree::Node> ends;
    std::vector<Particle> particles;
    particles.reserve(drawn.size());
    for (std::size_t k = 0; k < drawn.size(); ++k) {
      Particle& from = particles_[drawn[k]];
      const bool last = k + 1 == drawn.size() || drawn[k + 1] != drawn[k];
      ends.push_back(ends_[drawn[k]]);
      if (last)
        particles.push_back(std::move(from));
      else
        particles.push_back(from);
    }
    for (const AncestryTree::Node end : ends_) tree_.release(end);
    ends_ = std::move(ends);
    particles_ = std::move(particles);
  }

  Rng rng_;
  std::uint64_t updates_ = 0;
  std::vector<Particle> particles_;
  std::vector<double> log_weights_;
  AncestryTree tree_;
  std::vector<AncestryTree::Node> ends_;
};

}  // namespace wayfare
