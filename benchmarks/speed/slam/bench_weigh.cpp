// Time per particle and beam: weighting alone, a plain implementation, and the complete localiser.
// On the demo's building at 5 cm.

#include <cmath>
#include <memory>
#include <vector>

#include <benchmark/benchmark.h>

#include <wayfare/filter/particle_filter.hpp>
#include <wayfare/sim/floor_plan.hpp>
#include <wayfare/sim/simulate_recording.hpp>
#include <wayfare/slam/localisation.hpp>

#include "slam/localisation/particle_set.hpp"
#include "slam/localisation/scan_weigher.hpp"

namespace wayfare {
namespace {

struct Scene {
  Recording recording;
  SE2d start;
  std::shared_ptr<const LocalisationMap> map;
  DistanceField distances;
};

const Scene& scene() {
  static const Scene s = [] {
    auto planned = sim::read_plan(sim::demo_building());
    planned->route_m.resize(3);
    auto run = sim::simulate_recording(planned->plan, planned->route_m, {}, Rng(1));
    const auto grid = sim::map_of_plan(planned->plan, planned->route_m.front());
    return Scene{run->recording, run->truth.front().T_map_base.raw(), *LocalisationMap::make(*grid),
                 *DistanceField::of_grid(*grid)};
  }();
  return s;
}

ParticleSet particles_near(const SE2d& pose, std::size_t n) {
  ParticleSet set;
  set.resize(n);
  for (std::size_t i = 0; i < n; ++i) set.set(i, pose);
  const MotionSampler draw({SE2d(), Eigen::Vector3d(0.1, 0.1, 0.01).asDiagonal()});
  propagate(
      set, [&](const SE2d& x, Rng& rng) { return x * draw(rng); }, Rng(2));
  return set;
}

void per_beam(benchmark::State& state, double beams) {
  state.counters["ns_per_beam"] = benchmark::Counter(
      1e-9 * beams, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void weigh(benchmark::State& state, ScanLikelihood model) {
  const Scene& s = scene();
  LocalisationOptions options;
  options.model = model;
  const ScanWeigher scan(s.recording.scans.front(), options);
  const ParticleSet set = particles_near(s.start, 1000);
  std::vector<double> log_likelihood(set.size());
  for (auto _ : state) {
    scan.weigh(*s.map, false, set, log_likelihood);
    benchmark::DoNotOptimize(log_likelihood.data());
  }
  per_beam(state, 1000.0 * options.beams);
}
void weigh_field(benchmark::State& state) { weigh(state, ScanLikelihood::likelihood_field); }
void weigh_beam(benchmark::State& state) { weigh(state, ScanLikelihood::beam); }
BENCHMARK(weigh_field)->Name("weigh_1000_particles/wayfare_field")->Unit(benchmark::kMicrosecond);
BENCHMARK(weigh_beam)->Name("weigh_1000_particles_by_beam/wayfare")->Unit(benchmark::kMicrosecond);

/// The plain likelihood field: distance of every beam's end, an exponential and a logarithm.
void weigh_plain(benchmark::State& state) {
  const Scene& s = scene();
  const LaserScan& scan = s.recording.scans.front();
  const ParticleSet set = particles_near(s.start, 1000);
  std::vector<double> log_likelihood(set.size());
  std::vector<Eigen::Vector2d> ends;
  for (std::size_t k = 0; k < 64; ++k) {
    const std::size_t i = k * scan.ranges_m.size() / 64;
    const double b = scan.bearing(i).radians();
    ends.push_back(static_cast<double>(scan.ranges_m[i]) *
                   Eigen::Vector2d(std::cos(b), std::sin(b)));
  }
  for (auto _ : state) {
    for (std::size_t i = 0; i < set.size(); ++i) {
      const SE2d pose = set.state(i);
      double sum = 0.0;
      for (const Eigen::Vector2d& p : ends) {
        const double d = s.distances.distance_m(cell_of(pose * p, 0.05)) / 0.08;
        sum += std::log(0.05 + 0.95 * std::exp(-0.5 * d * d));
      }
      log_likelihood[i] = sum;
    }
    benchmark::DoNotOptimize(log_likelihood.data());
  }
  per_beam(state, 1000.0 * 64.0);
}
BENCHMARK(weigh_plain)->Name("weigh_1000_particles/plain")->Unit(benchmark::kMicrosecond);

/// Motion, weighting, clustering and resampling of 500 and more particles.
void track(benchmark::State& state) {
  const Scene& s = scene();
  double beams = 0.0;
  for (auto _ : state) {
    const auto run =
        run_localisation(s.recording, s.map, {}, 1,
                         Gaussian<SE2d>{s.start, Eigen::Vector3d(0.01, 0.01, 0.003).asDiagonal()});
    beams = 0.0;
    for (const LocalisationOutcome& o : run->outcomes)
      beams += 64.0 * static_cast<double>(o.particles);
    benchmark::DoNotOptimize(beams);
  }
  per_beam(state, beams);
  state.counters["scans"] = static_cast<double>(s.recording.scans.size());
}
BENCHMARK(track)->Name("track_a_drive/wayfare")->Unit(benchmark::kMillisecond);

/// Global localisation: a search over the building with 20000 particles.
void find(benchmark::State& state) {
  const Scene& s = scene();
  for (auto _ : state) {
    Localiser localiser(s.map, {}, 1);
    benchmark::DoNotOptimize(localiser.add_scan(s.recording.scans.front(), {}));
  }
}
BENCHMARK(find)->Name("find_from_nowhere/wayfare")->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace wayfare
