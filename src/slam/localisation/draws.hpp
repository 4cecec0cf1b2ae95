#pragma once

#include <cstddef>
#include <span>

#include <wayfare/core/random.hpp>
#include <wayfare/slam/localisation.hpp>

#include "slam/localisation/particle_set.hpp"
#include "slam/localisation/pose_bins.hpp"

namespace wayfare {

/// Fox 2003, equation (7): number of particles that bounds the Kullback-Leibler distance of a
/// histogram of `k` bins by the options' error.
[[nodiscard]] double kld_bound(std::size_t k, const LocalisationOptions& options);

/// Draws by weight, as many as KLD sampling requires, at least `least` and within the options'
/// limit.
[[nodiscard]] ParticleSet resample_adaptively(const ParticleSet& from, const PoseBins& bins,
                                              const LocalisationOptions& options, std::size_t least,
                                              Rng& rng);

/// `count` draws by weight, each with normal noise: separates copies of one particle.
[[nodiscard]] ParticleSet resample_with_noise(const ParticleSet& from, std::size_t count,
                                              double sigma_m, double sigma_rad, Rng& rng);

/// Poses evenly spread over the map's free cells, each at a random heading.
[[nodiscard]] ParticleSet uniform_poses(const LocalisationMap& map,
                                        const LocalisationOptions& options, const Rng& rng);

/// Moves every particle by its own sample of `motion`.
void move(ParticleSet& particles, const Gaussian<SE2d>& motion, int threads, const Rng& rng);

}  // namespace wayfare
