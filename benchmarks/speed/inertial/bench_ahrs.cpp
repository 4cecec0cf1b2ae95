// Time per nine-axis sample of wayfare's, Madgwick's and Mahony's filters.

#include <benchmark/benchmark.h>

#include <cmath>
#include <cstddef>
#include <cstdint>

#include <wayfare/core/random.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/inertial/ahrs.hpp>

namespace {

using namespace wayfare;

/// Ten seconds at 100 Hz of a rotating body, with noise.
MargRecording turning_body() {
  Rng rng(1);
  const auto noise = [&](double sigma) {
    const double x = rng.normal(0.0, sigma), y = rng.normal(0.0, sigma);
    return Eigen::Vector3d(x, y, rng.normal(0.0, sigma));
  };
  MargRecording samples;
  SO3d q;
  for (int i = 0; i < 1000; ++i) {
    const double t = 0.01 * i;
    const Eigen::Vector3d rate(std::sin(t), std::cos(1.3 * t), std::sin(0.7 * t + 1.0));
    q = q * SO3d::exp(0.01 * rate);
    samples.push_back({LogTime::from_nanoseconds(std::int64_t{10'000'000} * i), rate + noise(0.01),
                       q.inverse() * Eigen::Vector3d(0.0, 0.0, 9.81) + noise(0.1),
                       q.inverse() * Eigen::Vector3d(0.0, 18.0, -42.0) + noise(0.5)});
  }
  return samples;
}

template <class Estimator>
void sample(benchmark::State& state) {
  MargRecording samples = turning_body();
  const Duration lap = samples.back().time - samples.front().time + from_seconds(0.01);
  Estimator estimator;
  std::size_t next = 0;
  for (auto _ : state) {
    estimator.add(samples[next]);
    benchmark::DoNotOptimize(estimator);
    samples[next].time += lap;  // times increase from lap to lap
    if (++next == samples.size()) next = 0;
  }
}

BENCHMARK(sample<Ahrs<frame::Ned, double>>)->Name("nine_axis_sample/wayfare");
BENCHMARK(sample<MadgwickAhrs<frame::Ned, double>>)->Name("nine_axis_sample/madgwick");
BENCHMARK(sample<MahonyAhrs<frame::Ned, double>>)->Name("nine_axis_sample/mahony");
BENCHMARK(sample<Ahrs<frame::Ned, float>>)->Name("nine_axis_sample_float/wayfare");
BENCHMARK(sample<MadgwickAhrs<frame::Ned, float>>)->Name("nine_axis_sample_float/madgwick");
BENCHMARK(sample<MahonyAhrs<frame::Ned, float>>)->Name("nine_axis_sample_float/mahony");

}  // namespace
