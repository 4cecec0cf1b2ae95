// The navigation filter on a real drive, compared with the same model in dense algebra. The unit's
// readings are real, the ranges simulated from the RTK positions (see tests/system/drive_0708.hpp).
// Times per filter: those of packs are divided by their lanes. `apart_mm` is the largest
// distance between the positions of this filter and of the dense one.

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>

#include <wayfare/nav/ins_filter.hpp>

#include "nav/drive_0708.hpp"

namespace wayfare {
namespace {

using Eigen::Vector3d;
using Ins = InsState<double, 0>;
using Square = Eigen::Matrix<double, 23, 23>;

/// One prediction, and the ranges measured at its end.
struct Step {
  ImuInterval imu;
  const RangeEpoch* epoch = nullptr;
};

struct Recording {
  std::vector<RangeEpoch> epochs;
  std::vector<Step> steps;
  std::vector<ImuSample> imu;  ///< as recorded
  GnssInsOptions options;
  Geodetic anchor;
  Ins start;
  Vector3d lever;
};

ImuSample halfway(const ImuSample& a, const ImuSample& b, LogTime t) {
  const double u = to_seconds(t - a.time) / to_seconds(b.time - a.time);
  return {t, a.angular_rate_radps + u * (b.angular_rate_radps - a.angular_rate_radps),
          a.specific_force_mps2 + u * (b.specific_force_mps2 - a.specific_force_mps2)};
}

/// Readings split at the epochs, so that every epoch ends a step.
void add_steps(Recording& r, const std::vector<ImuSample>& imu, LogTime begin) {
  auto epoch = std::find_if(r.epochs.begin(), r.epochs.end(),
                            [begin](const RangeEpoch& e) { return e.time > begin; });
  std::optional<ImuSample> last;
  for (const ImuSample& sample : imu) {
    if (sample.time <= begin) continue;
    while (last && epoch != r.epochs.end() && epoch->time < sample.time) {
      if (epoch->time > last->time) {
        const ImuSample cut = halfway(*last, sample, epoch->time);
        r.steps.push_back({between(*last, cut), &*epoch});
        last = cut;
      }
      ++epoch;
    }
    if (last && sample.time > last->time) r.steps.push_back({between(*last, sample), nullptr});
    last = sample;
  }
}

std::optional<Recording> load() {
  if (!std::filesystem::exists(tests::drive_0708_folder())) return std::nullopt;
  auto drive = tests::load_drive_0708();
  if (!drive) return std::nullopt;
  const auto antenna = tests::antenna_trajectory(*drive);
  if (!antenna) return std::nullopt;
  Recording r;
  r.epochs = tests::simulated_ranges(*antenna, 1).epochs;
  r.options = tests::drive_0708_options();
  r.imu = drive->imu;
  for (ImuSample& s : drive->imu) s.time += from_seconds(r.options.imu_time_offset_s);
  LogTime begin = antenna->begin();
  while (antenna->state(begin).velocity_ned_mps.norm() < 5.0) begin += std::chrono::seconds(1);
  const NavState truth = antenna->state(begin);
  r.anchor = truth.position;
  r.start.velocity_mps = truth.velocity_ned_mps;
  r.start.q_nu = truth.q_nb * r.options.q_body_imu;
  r.start.clock << 300.0, 5.0;
  r.lever = r.options.q_body_imu.inverse() * r.options.antenna_lever_arm_m;
  add_steps(r, drive->imu, begin);
  return r;
}

const std::optional<Recording>& recording() {
  static const std::optional<Recording> loaded = load();
  return loaded;
}

Square start_covariance(const GnssInsOptions& o) {
  Eigen::Matrix<double, 23, 1> sigma;
  sigma << Vector3d::Constant(5.0), Vector3d::Constant(0.5), Vector3d::Constant(0.1),
      o.imu.gyro_bias_radps.sigma, o.imu.accel_bias_mps2.sigma, o.imu.gyro_scale.sigma,
      o.imu.accel_scale.sigma, 100.0, 10.0;
  return sigma.cwiseAbs2().asDiagonal();
}

/// Plain implementation: dense Φ P Φᵀ + Q, and the measurements of an epoch as one block in Joseph
/// form.
class DenseFilter {
 public:
  explicit DenseFilter(const Recording& r)
      : x_(r.start),
        p_(start_covariance(r.options)),
        plane_(r.anchor),
        model_(plane_, InsNoise<double>(r.options.imu, r.options.clock)),
        lever_(r.lever) {}

  void predict(const ImuInterval& imu) {
    const auto step = model_(x_, imu);
    const Square phi = step.phi();
    x_ = step.state;
    p_ = phi * p_ * phi.transpose() + step.q();
    gyro_radps_ = imu.end_rate_radps;
  }

  void update(const RangeEpoch& epoch) {
    constexpr int kMost = 32;
    using Rows = Eigen::Matrix<double, Eigen::Dynamic, 23, Eigen::RowMajor, kMost, 23>;
    using Numbers = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMost, 1>;
    using Noise = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMost, kMost>;
    const auto rows = static_cast<Eigen::Index>(2 * epoch.satellites.size());
    Rows h = Rows::Zero(rows, 23);
    Numbers nu(rows), r(rows);
    Eigen::Index row = 0;
    const auto put = [&](const auto& m) {
      for (std::size_t k = 0; k < m.row.index.size(); ++k) h(row, m.row.index[k]) += m.row.value[k];
      nu[row] = m.innovation, r[row] = m.variance, ++row;
    };
    for (const CorrectedRange& s : epoch.satellites) {
      const SatelliteView view(s, plane_);
      const double range = s.range_sigma_m * s.range_sigma_m;
      const double rate = s.range_rate_sigma_mps * s.range_rate_sigma_mps;
      put(RangeModel<double>{plane_, view, s.range_m - view.anchor_range_m, range, lever_}(x_));
      put(RangeRateModel<double>{plane_, view, s.range_rate_mps, rate, lever_, gyro_radps_}(x_));
    }
    const Noise innovation = h * p_ * h.transpose() + Noise(r.asDiagonal());
    const Eigen::Matrix<double, 23, Eigen::Dynamic, 0, 23, kMost> k =
        innovation.llt().solve(h * p_).transpose();
    x_ = x_.plus(k * nu);
    const Square keep = Square::Identity() - k * h;
    p_ = keep * p_ * keep.transpose() + k * r.asDiagonal() * k.transpose();
  }

  [[nodiscard]] Geodetic position() const { return plane_.geodetic(x_.position_m); }

 private:
  Ins x_;
  Square p_;
  LocalTangentPlane plane_;
  InsModel<double, 0> model_;
  Vector3d lever_, gyro_radps_ = Vector3d::Zero();
};

template <class T>
class OurFilter {
 public:
  explicit OurFilter(const Recording& r)
      : filter_(r.anchor, 0.0, r.start.template cast<T>(),
                start_covariance(r.options).template cast<T>(),
                InsNoise<T>(r.options.imu, r.options.clock), r.lever) {}

  void predict(const ImuInterval& imu) { filter_.predict(imu); }
  void update(const RangeEpoch& epoch) {
    constexpr double kNoGate = 1e6;
    for (const CorrectedRange& s : epoch.satellites) {
      filter_.update_range(s, T(s.range_sigma_m), T(kNoGate));
      filter_.update_range_rate(s, T(s.range_rate_sigma_mps), T(kNoGate));
    }
  }
  [[nodiscard]] Geodetic position() const { return filter_.position(); }

 private:
  InsFilter<T, 0> filter_;
};

template <class Filter, class After>
void run(const Recording& r, const After& after) {
  Filter filter(r);
  for (const Step& step : r.steps) {
    filter.predict(step.imu);
    if (step.epoch) filter.update(*step.epoch);
    after(filter);
  }
}

template <class Filter>
std::vector<Geodetic> positions(const Recording& r) {
  std::vector<Geodetic> all;
  run<Filter>(r, [&all](const Filter& f) { all.push_back(f.position()); });
  return all;
}

template <class Filter>
double apart_mm(const Recording& r) {
  static const std::vector<Geodetic> dense = positions<DenseFilter>(r);
  const std::vector<Geodetic> mine = positions<Filter>(r);
  double most = 0.0;
  for (std::size_t i = 0; i < mine.size(); ++i)
    most = std::max(most, 1e3 * ned_from_geodetic(mine[i], dense[i]).norm());
  return most;
}

template <class Filter>
void whole_drive(benchmark::State& state, int lanes) {
  const auto& r = recording();
  if (!r) return state.SkipWithError("no recording drive_0708; set WAYFARE_DATA_DIR");
  state.counters["apart_mm"] = apart_mm<Filter>(*r);
  state.counters["predictions"] = static_cast<double>(r->steps.size());
  while (state.KeepRunningBatch(lanes))
    run<Filter>(*r, [](const Filter& f) { benchmark::DoNotOptimize(&f); });
}

/// The complete run_gnss_ins: 26 states, gates, late measurements, constraints, output at every
/// reading.
void whole_system(benchmark::State& state) {
  const auto& r = recording();
  if (!r) return state.SkipWithError("no recording drive_0708; set WAYFARE_DATA_DIR");
  const GnssInsRecording whole{r->imu, r->epochs, {}, {}};
  for (auto _ : state) {
    auto result = run_gnss_ins(whole, r->options);
    benchmark::DoNotOptimize(result);
  }
}

template <class Filter>
void add(const char* who, int lanes = 1) {
  benchmark::RegisterBenchmark(("ekf_drive_0708/" + std::string(who)).c_str(),
                               [lanes](benchmark::State& s) { whole_drive<Filter>(s, lanes); })
      ->Unit(benchmark::kMillisecond);
}

const bool kAdded = [] {
  add<OurFilter<double>>("wayfare");
  add<DenseFilter>("dense_eigen");
  add<OurFilter<Pack<double, 2>>>("pack_double2", 2);
  add<OurFilter<Pack<float, 4>>>("pack_float4", 4);
  benchmark::RegisterBenchmark("ekf_drive_0708/gnss_ins", whole_system)
      ->Unit(benchmark::kMillisecond);
  return true;
}();

}  // namespace
}  // namespace wayfare
