#include "slam/localisation/particle_set.hpp"

#include <algorithm>
#include <numbers>

#include <wayfare/filter/particle_filter.hpp>
#include <wayfare/slam/detail/pose_filter.hpp>

namespace wayfare {

ParticleSet ParticleSet::anywhere(const LocalisationMap& map, const MonteCarloOptions& options,
                                  const Rng& rng) {
  const double cell_m = map.resolution_m();
  const auto places = static_cast<double>(map.free_cells().size());
  ParticleSet poses;
  poses.resize(
      detail::candidate_count(options.candidates_per_m2 * places * cell_m * cell_m, options));
  const double stride = places / static_cast<double>(poses.size());
  detail::for_particles(poses.size(), options.threads, rng, [&](std::size_t i, Rng& own) {
    const double at = (static_cast<double>(i) + own.uniform()) * stride;
    const auto place = std::min(static_cast<std::size_t>(at), map.free_cells().size() - 1);
    const Cell& c = map.free_cells()[place];
    poses.x_m[i] = (c.x + own.uniform()) * cell_m;
    poses.y_m[i] = (c.y + own.uniform()) * cell_m;
    poses.heading_rad[i] = own.uniform(-std::numbers::pi, std::numbers::pi);
  });
  return poses;
}

}  // namespace wayfare
