// τ for ten particles, a thousand samples each, of the scene's 356 points: on a lattice, and by the
// plain formula.

#include <vector>

#include <benchmark/benchmark.h>

#include <wayfare/match/pose_proposal.hpp>

#include "match/naive_pose_proposal.hpp"
#include "scene.hpp"

namespace wayfare {
namespace {

constexpr int kParticles = 10, kSamples = 1000;

struct Particle {
  Gaussian<SE2d> match, motion;
};

std::vector<Particle> particles() {
  Rng rng(2);
  std::vector<Particle> all;
  for (int i = 0; i < kParticles; ++i) {
    const SE2d pose =
        scene().poses[20].plus({rng.normal(0, 0.03), rng.normal(0, 0.03), rng.normal(0, 0.01)});
    all.push_back({{pose, Eigen::Vector3d(9e-4, 9e-4, 3e-4).asDiagonal()},
                   {pose.plus({0.02, 0.01, 0.0}), Eigen::Vector3d(1e-2, 1e-2, 2e-3).asDiagonal()}});
  }
  return all;
}

void lattice(benchmark::State& state) {
  const auto all = particles();
  PoseProposalOptions options;
  options.samples = kSamples;
  options.independent_points = 20;
  PoseProposal proposal;
  Rng rng(3);
  for (auto _ : state)
    for (const Particle& p : all)
      benchmark::DoNotOptimize(
          proposal.draw(scene().field, scene().seen, p.match, p.motion, rng, options));
}
BENCHMARK(lattice)->Name("pose_proposal/wayfare")->Unit(benchmark::kMicrosecond);

void naive(benchmark::State& state) {
  const auto all = particles();
  Rng rng(3);
  for (auto _ : state)
    for (const Particle& p : all)
      benchmark::DoNotOptimize(
          naive_draw(scene().field, scene().seen, p.match, p.motion, rng, kSamples, 20));
}
BENCHMARK(naive)->Name("pose_proposal/naive_double")->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace wayfare
