// EXPECT: a sampler of motions is called as sampler
#include <wayfare/filter/particle_filter.hpp>

struct Walk {
#ifdef WAYFARE_MUST_FAIL
  Eigen::Vector2d operator()(wayfare::Rng& rng) const { return {rng.normal(), 0.0}; }
#else
  Eigen::Vector2d operator()(const Eigen::Vector2d& x, wayfare::Rng& rng) const {
    return {x[0] + rng.normal(), x[1]};
  }
#endif
};

void move(wayfare::Particles<Eigen::Vector2d>& particles) {
  wayfare::propagate(particles, Walk{}, wayfare::Rng(1));
}
