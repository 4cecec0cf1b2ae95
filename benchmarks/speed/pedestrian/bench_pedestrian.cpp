// Time per reading: the foot tracker, its filter compared with a dense one, and dead reckoning by
// steps with and without its attitude filter.

#include <benchmark/benchmark.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <vector>

#include <wayfare/core/se3.hpp>
#include <wayfare/pedestrian/foot_tracker.hpp>
#include <wayfare/pedestrian/pedestrian.hpp>
#include <wayfare/sim/walks.hpp>

namespace {

using namespace wayfare;

const std::vector<ImuSample>& foot_samples() {
  static const auto truth = sim::simulate_feet({}, {}, Rng(1));
  return truth.left.samples;
}

/// Twenty seconds of steps, twice a second, with all three sensors.
MargRecording walker() {
  MargRecording samples;
  for (int i = 0; i < 2000; ++i) {
    const double t = 0.01 * i, swing = 3.0 * std::sin(2.0 * std::numbers::pi * 2.0 * t);
    samples.push_back({LogTime::from_nanoseconds(std::int64_t{10'000'000} * i),
                       {0.0, 0.0, 0.05 * std::sin(0.3 * t)},
                       {0.3 * swing, 0.0, 9.80665 + swing},
                       {0.0, 18.0, -42.0}});
  }
  return samples;
}

/// Feeds a recording repeatedly, with increasing times.
template <class Sample, class Use>
void feed(benchmark::State& state, std::vector<Sample> samples, Use use) {
  const Duration lap = samples.back().time - samples.front().time + from_seconds(0.01);
  std::size_t next = 0;
  for (auto _ : state) {
    use(samples[next]);
    samples[next].time += lap;
    if (++next == samples.size()) next = 0;
  }
}

void foot_tracker(benchmark::State& state) {
  FootTracker tracker;
  feed(state, foot_samples(), [&](const ImuSample& s) {
    tracker.add(s);
    benchmark::DoNotOptimize(tracker);
  });
}

void foot_filter(benchmark::State& state) {
  FootFilter filter;
  filter.set_attitude(SO3d(), Eigen::Vector3d::Constant(1e-4));
  filter.set_bias_variances(1e-6, 1e-2);
  const FootFilter::Noise noise{0.0, 1e-6, 1e-8, 1e-12, 1e-9};
  int n = 0;
  feed(state, foot_samples(), [&](const ImuSample& s) {
    filter.predict(s.angular_rate_radps, s.specific_force_mps2, 9.80665, 0.01);
    filter.add_noise(noise);
    if (++n % 100 == 0) filter.observe<FootFilter::kVelocity>(Eigen::Vector3d::Zero(), 1e-4);
    benchmark::DoNotOptimize(filter);
  });
}

/// The same filter with dense matrices of dynamic size Φ, Q and H.
class DenseFoot {
 public:
  void predict(const Eigen::Vector3d& rate, const Eigen::Vector3d& force, double dt) {
    const Eigen::Matrix3d r = q_.matrix();
    const Eigen::Vector3d world = r * (force - x_.segment(12, 3));
    const Eigen::Vector3d a = world - Eigen::Vector3d(0.0, 0.0, 9.80665);
    x_.segment(0, 3) += x_.segment(3, 3) * dt + 0.5 * a * dt * dt;
    x_.segment(3, 3) += a * dt;
    q_ = q_ * SO3d::exp((rate - x_.segment(9, 3)) * dt);
    Eigen::MatrixXd phi = Eigen::MatrixXd::Identity(15, 15), q = Eigen::MatrixXd::Zero(15, 15);
    phi.block(0, 3, 3, 3) = dt * Eigen::Matrix3d::Identity();
    phi.block(3, 6, 3, 3) = -dt * skew<double>(world);
    phi.block(3, 12, 3, 3) = -dt * r;
    phi.block(6, 9, 3, 3) = -dt * r;
    q.diagonal() << 0, 0, 0, 1e-6, 1e-6, 1e-6, 1e-8, 1e-8, 1e-8, 1e-12, 1e-12, 1e-12, 1e-9, 1e-9,
        1e-9;
    p_ = phi * p_ * phi.transpose() + q;
  }
  void add_zero_velocity() {
    Eigen::MatrixXd h = Eigen::MatrixXd::Zero(3, 15);
    h.block(0, 3, 3, 3).setIdentity();
    const Eigen::MatrixXd s = h * p_ * h.transpose() + 1e-4 * Eigen::MatrixXd::Identity(3, 3);
    const Eigen::MatrixXd k = p_ * h.transpose() * s.inverse();
    const Eigen::VectorXd d = k * -x_.segment(3, 3);
    const Eigen::MatrixXd rest = Eigen::MatrixXd::Identity(15, 15) - k * h;
    p_ = rest * p_ * rest.transpose() + 1e-4 * k * k.transpose();
    q_ = SO3d::exp(Eigen::Vector3d(d.segment(6, 3))) * q_;
    x_ += d;
  }

 private:
  SO3d q_;
  Eigen::VectorXd x_ = Eigen::VectorXd::Zero(15);
  Eigen::MatrixXd p_ = 1e-4 * Eigen::MatrixXd::Identity(15, 15);
};

void dense_foot_filter(benchmark::State& state) {
  DenseFoot filter;
  int n = 0;
  feed(state, foot_samples(), [&](const ImuSample& s) {
    filter.predict(s.angular_rate_radps, s.specific_force_mps2, 0.01);
    if (++n % 100 == 0) filter.add_zero_velocity();
    benchmark::DoNotOptimize(filter);
  });
}

void pedestrian(benchmark::State& state) {
  Pedestrian walking;
  feed(state, walker(), [&](const MargSample& s) {
    walking.add(s);
    benchmark::DoNotOptimize(walking);
  });
}
void attitude_alone(benchmark::State& state) {
  Ahrs<frame::Enu> ahrs(indoor_ahrs_parameters());
  feed(state, walker(), [&](const MargSample& s) {
    ahrs.add(s);
    benchmark::DoNotOptimize(ahrs);
  });
}
void step_detector(benchmark::State& state) {
  StepDetector detector;
  feed(state, walker(), [&](const MargSample& s) {
    detector.add(s.time, s.specific_force_mps2, [](const Step&) {});
    benchmark::DoNotOptimize(detector);
  });
}

BENCHMARK(foot_tracker)->Name("foot_sample/tracker");
BENCHMARK(foot_filter)->Name("foot_sample/filter_alone");
BENCHMARK(dense_foot_filter)->Name("foot_sample/dense_baseline");
BENCHMARK(pedestrian)->Name("walk_sample/pedestrian");
BENCHMARK(attitude_alone)->Name("walk_sample/attitude_alone");
BENCHMARK(step_detector)->Name("walk_sample/step_detector");

}  // namespace
