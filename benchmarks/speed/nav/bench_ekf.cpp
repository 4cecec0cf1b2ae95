// The 23-state navigation filter, compared with dense algebra: the covariance step alone, and ten
// seconds of driving. Times per filter: those of packs are divided by their lanes.

#include <cmath>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include <wayfare/nav/ins_filter.hpp>

namespace wayfare {
namespace {

using Eigen::Vector3d;
using Square = Eigen::Matrix<double, 23, 23>;
using Ins = InsState<double, 0>;

const Geodetic kAnchor{Angle::degrees(48.7), Angle::degrees(9.1), 300.0};
const ImuInterval kImu{
    {0.01, -0.005, 0.1}, {0.012, -0.004, 0.11}, {0.3, 0.5, -9.7}, {0.2, 0.6, -9.9}, 0.01};

Ins start() {
  Ins x;
  x.velocity_mps = Vector3d(9.0, 5.0, 0.0);
  x.q_nu = SO3d::exp(Vector3d(0.02, -0.03, 0.5));
  return x;
}
Square start_covariance() {
  Eigen::Matrix<double, 23, 1> sigma;
  sigma << 2, 2, 2, 0.2, 0.2, 0.2, 0.01, 0.01, 0.05, 1e-3, 1e-3, 1e-3, 0.05, 0.05, 0.05, 3e-3, 3e-3,
      3e-3, 3e-3, 3e-3, 3e-3, 10, 1;
  return sigma.cwiseAbs2().asDiagonal();
}
template <class T>
auto one_step() {
  const LocalTangentPlane plane(kAnchor);
  return InsModel<T, 0>(plane, InsNoise<T>(ImuNoise{}, {}))(start().cast<T>(), kImu);
}

/// Times `step`, which processes this number of filters.
template <class Step>
void measure(benchmark::State& state, int filters, const Step& step) {
  while (state.KeepRunningBatch(filters)) step();
}

void dense_step(benchmark::State& state) {
  const Square phi = one_step<double>().phi(), q = one_step<double>().q();
  Square p = start_covariance(), left;
  measure(state, 1, [&] {
    left.noalias() = phi * p;
    p.noalias() = left * phi.transpose();
    p += q;
    benchmark::DoNotOptimize(p.data());
    benchmark::ClobberMemory();
  });
}

template <class T>
void sparse_step(benchmark::State& state) {
  const auto f = one_step<T>();
  Eigen::Matrix<T, 23, 23> p = start_covariance().cast<T>();
  measure(state, LaneOf<T>::kLanes, [&] {
    f.propagate(p);
    benchmark::DoNotOptimize(p.data());
    benchmark::ClobberMemory();
  });
}

/// Eight satellites.
std::vector<CorrectedRange> epoch() {
  std::vector<CorrectedRange> satellites;
  for (int i = 0; i < 8; ++i) {
    const double a = 2.4 * i, e = 0.35 + 0.13 * i;
    CorrectedRange s;
    s.position_ecef_m =
        ecef_from_geodetic(kAnchor) +
        rotation_ecef_ned(kAnchor) *
            (2.2e7 * Vector3d(std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), -std::sin(e)));
    s.range_m = (s.position_ecef_m - ecef_from_geodetic(kAnchor)).norm();
    s.range_rate_mps = 0.0;
    satellites.push_back(s);
  }
  return satellites;
}

constexpr int kSeconds = 10, kImuRate = 100, kRangeRate = 4;

/// Plain implementation: dense Φ P Φᵀ + Q, and all measurements of an epoch as one block.
struct NaiveFilter {
  Ins x = start();
  Square p = start_covariance();
  LocalTangentPlane plane{kAnchor};
  InsModel<double, 0> model{plane, InsNoise<double>(ImuNoise{}, {})};

  void predict() {
    const auto step = model(x, kImu);
    const Square phi = step.phi();
    x = step.state;
    p = phi * p * phi.transpose() + step.q();
  }
  void update(const std::vector<CorrectedRange>& satellites) {
    Eigen::Matrix<double, 16, 23> h = Eigen::Matrix<double, 16, 23>::Zero();
    Eigen::Matrix<double, 16, 1> nu;
    Eigen::Matrix<double, 16, 16> r = Eigen::Matrix<double, 16, 16>::Zero();
    const auto put = [&](int row, const auto& m) {
      for (std::size_t k = 0; k < m.row.index.size(); ++k) h(row, m.row.index[k]) += m.row.value[k];
      nu[row] = m.innovation;
      r(row, row) = m.variance;
    };
    for (int i = 0; i < 8; ++i) {
      const CorrectedRange& s = satellites[static_cast<std::size_t>(i)];
      const SatelliteView view(s, plane);
      put(2 * i, RangeModel<double, 0>{plane, view, s.range_m - view.anchor_range_m, 4.0,
                                       Vector3d::Zero()}(x));
      put(2 * i + 1,
          RangeRateModel<double, 0>{plane, view, 0.0, 0.01, Vector3d::Zero(), Vector3d::Zero()}(x));
    }
    const Eigen::Matrix<double, 23, 16> k =
        p * h.transpose() * (h * p * h.transpose() + r).inverse();
    x = x.plus(k * nu);
    const Square keep = Square::Identity() - k * h;
    p = keep * p * keep.transpose() + k * r * k.transpose();
  }
};

template <class T>
struct OurFilter {
  InsFilter<T, 0> filter{kAnchor,
                         0.0,
                         start().cast<T>(),
                         start_covariance().cast<T>(),
                         InsNoise<T>(ImuNoise{}, {}),
                         Vector3d::Zero()};
  void predict() { filter.predict(kImu); }
  void update(const std::vector<CorrectedRange>& satellites) {
    for (const CorrectedRange& s : satellites) {
      filter.update_range(s, T(2), T(1e6));
      filter.update_range_rate(s, T(0.1), T(1e6));
    }
  }
};

template <class Filter>
void drive(benchmark::State& state, int lanes) {
  const auto satellites = epoch();
  measure(state, lanes, [&] {
    Filter filter;
    for (int i = 0; i < kSeconds * kImuRate; ++i) {
      filter.predict();
      if (i % (kImuRate / kRangeRate) == 0) filter.update(satellites);
    }
    benchmark::DoNotOptimize(filter);
  });
}

#ifndef WAYFARE_BENCH_ISA
#define WAYFARE_BENCH_ISA "sse2"
#endif

template <class T>
void add_width(const char* who) {
  const std::string isa = WAYFARE_BENCH_ISA;
  benchmark::RegisterBenchmark(("ekf_covariance/" + std::string(who) + "/" + isa).c_str(),
                               sparse_step<T>);
  benchmark::RegisterBenchmark(
      ("ekf_drive_10s/" + std::string(who) + "/" + isa).c_str(),
      [](benchmark::State& s) { drive<OurFilter<T>>(s, LaneOf<T>::kLanes); });
}

const bool kAdded = [] {
#ifdef __AVX2__
  if (!__builtin_cpu_supports(WAYFARE_BENCH_ISA)) return false;
#endif
  const std::string isa = WAYFARE_BENCH_ISA;
  add_width<double>("wayfare");
  benchmark::RegisterBenchmark(("ekf_covariance/dense_eigen/" + isa).c_str(), dense_step);
  benchmark::RegisterBenchmark(("ekf_drive_10s/dense_eigen/" + isa).c_str(),
                               [](benchmark::State& s) { drive<NaiveFilter>(s, 1); });
  add_width<Pack<double, 2>>("pack_double2");
  add_width<Pack<double, 4>>("pack_double4");
  add_width<Pack<double, 8>>("pack_double8");
  add_width<Pack<float, 4>>("pack_float4");
  add_width<Pack<float, 8>>("pack_float8");
  add_width<Pack<float, 16>>("pack_float16");
  return true;
}();

}  // namespace
}  // namespace wayfare
