// The particle filter on the beginning of real drives: time per scan and particle, with up to 1000
// particles, and time to resample 30 particles.

#include <sys/resource.h>

#include <chrono>
#include <cmath>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include <wayfare/filter/rbpf.hpp>
#include <wayfare/slam/radar_slam.hpp>

#include "drive.hpp"

namespace wayfare {
namespace {

/// σ = 3 cm + 25 %, 3° + 20 %.
Gaussian<SE2d> with_noise(const SE2d& increment) {
  const double along = 0.03 + 0.25 * increment.translation().norm();
  const double turn = 0.05 + 0.2 * std::abs(increment.heading().radians());
  return {increment, Eigen::Vector3d(along * along, along * along, turn * turn).asDiagonal()};
}

RadarSlam run(const Drive& drive, std::size_t particles, int threads = 1) {
  RadarSlamOptions options;
  options.particles = particles;
  options.threads = threads;
  options.T_base_laser = Transform2<frame::Base, frame::Laser>(drive.T_base_laser);
  RadarSlam slam(options);
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    (void)slam.move(with_noise(drive.increments[i]));
    (void)slam.add_lidar(drive.scans[i]);
  }
  return slam;
}

double peak_mb() {
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  return static_cast<double>(used.ru_maxrss) / 1e3;
}

/// Particles and threads. The time is the total CPU time per particle and scan. Updates per second
/// are by wall time, the peak memory is that of the process.
void particle_scan(benchmark::State& state, const std::string& name) {
  const Drive& drive = drive_of(name);
  if (drive.scans.empty()) return state.SkipWithError("no such recording in WAYFARE_DATA_DIR");
  const auto particles = static_cast<std::size_t>(state.range(0));
  for (auto _ : state) {
    const auto begun = std::chrono::steady_clock::now();
    const double start = cpu_seconds();
    const RadarSlam slam = run(drive, particles, static_cast<int>(state.range(1)));
    const double took = cpu_seconds() - start;
    const std::chrono::duration<double> lasted = std::chrono::steady_clock::now() - begun;
    if (slam.statistics().updates != drive.scans.size()) state.SkipWithError("scans left out");
    const double scans = static_cast<double>(drive.scans.size());
    state.SetIterationTime(took / scans / static_cast<double>(particles));
    state.counters["updates_per_s"] = scans / lasted.count();
    state.counters["peak_MB"] = peak_mb();
  }
}

void sizes(benchmark::internal::Benchmark* b) {
  b->ArgNames({"particles", "threads"})->Args({10, 1})->Args({30, 1})->Args({1000, 2});
  b->UseManualTime()->Iterations(1)->Unit(benchmark::kMicrosecond);
}
BENCHMARK_CAPTURE(particle_scan, Fr079, "fr079")->Name("particle_scan_fr079/wayfare")->Apply(sizes);
BENCHMARK_CAPTURE(particle_scan, Intel, "intel")->Name("particle_scan_intel/wayfare")->Apply(sizes);

/// With maps of a complete drive; one particle in three survives.
void resample_thirty(benchmark::State& state) {
  const Drive& drive = drive_of("fr079");
  if (drive.scans.empty()) return state.SkipWithError("no such recording in WAYFARE_DATA_DIR");
  const RadarSlam slam = run(drive, 30);
  const StampedPose start{drive.scans.front().time, Transform2<frame::Map, frame::Base>(SE2d())};
  for (auto _ : state) {
    state.PauseTiming();
    Rbpf<RbpfMaps> filter(30, start, RbpfMaps(), 1);
    std::size_t i = 0;
    const auto weighed =
        filter.update(drive.scans.back().time, [&](auto& particle, Rng&, std::size_t) {
          particle.map = slam.particles()[i].map;
          return i++ % 3 == 0 ? 0.0 : -50.0;
        });
    state.ResumeTiming();
    if (!weighed || !filter.resample_below()) state.SkipWithError("not resampled");
    benchmark::DoNotOptimize(filter);
  }
}
BENCHMARK(resample_thirty)->Name("resample_30/wayfare")->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace wayfare
