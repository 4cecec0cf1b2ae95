#pragma once

// Matchers of any type in likelihood fields, for the particle filter.

#include <concepts>
#include <functional>
#include <memory>
#include <optional>

#include <wayfare/map/likelihood_field.hpp>
#include <wayfare/match/scan_matcher.hpp>

namespace wayfare {

/// A matcher that finds the centre of a particle's proposal; it is refined in the same field.
template <class M>
concept FieldMatcher =
    ScanMatcher<M> && std::copy_constructible<M> && std::same_as<typename M::Map, LikelihoodField>;

namespace detail {

/// A matcher for one thread.
class ParticleMatcher {
 public:
  virtual ~ParticleMatcher() = default;
  [[nodiscard]] virtual Result<std::optional<MatchResult>> match(const LikelihoodField& field,
                                                                 const PointSet& points,
                                                                 const SE2d& prior,
                                                                 const SearchWindow& window,
                                                                 const MatchOptions& options) = 0;
};

template <FieldMatcher M>
class ParticleMatcherBy final : public ParticleMatcher {
 public:
  explicit ParticleMatcherBy(const M& matcher) : matcher_(matcher) {}
  Result<std::optional<MatchResult>> match(const LikelihoodField& field, const PointSet& points,
                                           const SE2d& prior, const SearchWindow& window,
                                           const MatchOptions& options) override {
    return matcher_.match(field, points, prior, window, options);
  }

 private:
  M matcher_;
};

using MakeParticleMatcher = std::function<std::unique_ptr<ParticleMatcher>()>;

template <FieldMatcher M>
[[nodiscard]] MakeParticleMatcher particle_matcher(const M& matcher) {
  return [=] { return std::make_unique<ParticleMatcherBy<M>>(matcher); };
}

}  // namespace detail

}  // namespace wayfare
