#include "links.hpp"

#include <cmath>

#include <wayfare/filter/particle_filter.hpp>

// A tank whose level is measured by a float that sticks: a particle filter of the library's steps,
// on a state of one number.
bool own_particles() {
  using Level = Eigen::Matrix<double, 1, 1>;
  const wayfare::Rng rng(1);
  const auto empty_to_full = [](wayfare::Rng& r) { return Level(r.uniform(0.0, 2.0)); };
  auto tank = wayfare::draw_particles(4000, empty_to_full, rng.stream(0));
  double level_m = 0.5;
  for (std::uint64_t k = 1; k <= 30; ++k) {
    level_m += 0.02;
    wayfare::Rng own = rng.stream(k);
    wayfare::propagate(
        tank, [](const Level& x, wayfare::Rng& r) { return Level(x[0] + r.normal(0.02, 0.01)); },
        own.stream(0));
    const double read_m = k % 7 == 0 ? 0.0 : level_m + own.normal(0.0, 0.05);
    wayfare::reweight(tank, [&](const Level& x) {
      const double d = (x[0] - read_m) / 0.05;
      return std::log(0.1 + std::exp(-0.5 * d * d));
    });
    const auto bins = [](const Level& x) {
      return wayfare::BinKey<1>{static_cast<int>(std::floor(x[0] / 0.02))};
    };
    tank = wayfare::resample_adaptively(tank, bins, {}, own);
  }
  return std::abs(wayfare::mean_and_covariance(tank).mean[0] - level_m) < 0.05;
}
