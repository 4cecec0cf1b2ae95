#pragma once

#include <cstddef>
#include <span>

#include <wayfare/core/random.hpp>
#include <wayfare/slam/localisation.hpp>

#include "slam/localisation/particle_set.hpp"
#include "slam/localisation/pose_bins.hpp"

namespace wayfare {

/// Fox 2003, equation (7): particles that hold the Kullback-Leibler distance of a histogram of `k`
/// bins below the options' error.
[[nodiscard]] double kld_bound(std::size_t k, const LocalisationOptions& options);

/// As many draws by weight as the bins they fall into ask for, at least `least` and within
/// the options' limit.
[[nodiscard]] ParticleSet draw_adaptively(const ParticleSet& from, const PoseBins& bins,
                                          const LocalisationOptions& options, std::size_t least,
                                          Rng& rng);

/// `count` draws by weight, each moved a little: apart from one another, where many are of one.
[[nodiscard]] ParticleSet draw_and_spread(const ParticleSet& from, std::size_t count,
                                          double sigma_m, double sigma_rad, Rng& rng);

/// Poses all over the map, evenly spread over its free places, each at a random heading.
[[nodiscard]] ParticleSet poses_anywhere(const LocalisationMap& map,
                                         const LocalisationOptions& options, const Rng& rng);

/// Moves every particle by its own draw of `motion`.
void move(ParticleSet& particles, const Gaussian<SE2d>& motion, int threads, const Rng& rng);

}  // namespace wayfare
