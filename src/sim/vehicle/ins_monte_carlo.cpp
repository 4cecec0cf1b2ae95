#include <wayfare/sim/ins_monte_carlo.hpp>

#include <algorithm>
#include <cstddef>
#include <functional>
#include <utility>
#include <vector>

#include <wayfare/core/parallel.hpp>
#include <wayfare/eval/consistency.hpp>
#include <wayfare/eval/nav_error.hpp>

namespace wayfare::sim {

namespace {

NisByKind nis_by_kind(const std::vector<InnovationRecord>& innovations) {
  NisByKind nis;
  for (const InnovationRecord& r : innovations) {
    NisSum& kind = nis[static_cast<std::size_t>(r.kind)];
    kind.sum += r.innovation * r.innovation / (r.sigma * r.sigma);
    ++kind.count;
  }
  return nis;
}

InsErrorAt error_at(const GnssInsEstimate& e, const NavState& truth, const ImuErrors& imu,
                    const ReceiverClock& clock) {
  const eval::NavError nav = eval::nav_error(e.nav, truth);
  InsErrorAt at;
  at.time = truth.time;
  at.error << nav.position_ned_m, nav.velocity_ned_mps, nav.attitude_body_rad,
      imu.gyro_bias_radps - e.gyro_bias_radps, imu.accel_bias_mps2 - e.accel_bias_mps2,
      imu.gyro_scale - e.gyro_scale, imu.accel_scale - e.accel_scale, clock.bias_m - e.clock_bias_m,
      clock.drift_mps - e.clock_drift_mps;
  at.sigma = e.covariance.diagonal().cwiseSqrt();
  at.nees = eval::normalised_squared(at.error, e.covariance);
  at.navigation_nees =
      eval::normalised_squared(at.error.head<9>(), e.covariance.topLeftCorner<9, 9>());
  return at;
}

/// The sensors of one run, and the filter's view of them.
struct Run {
  Run(const VehicleTrajectory& path, const Constellation& constellation,
      const InsMonteCarloOptions& options, const Rng& rng)
      : trajectory(path),
        unit(path, options.imu, rng.stream(0)),
        ranges(simulate_ranges(path, constellation, options.ranges, rng.stream(1))),
        filter(options.filter) {
    Rng start_noise = rng.stream(2);
    if (filter.odometer)
      wheels = simulate_wheel_speeds(path, options.wheels, rng.stream(3)).readings;
    filter.imu = options.imu.noise;
    filter.clock = options.ranges.clock;
    filter.q_body_imu = options.imu.q_body_imu;
    filter.antenna_lever_arm_m = options.ranges.antenna_lever_arm_m;
    start = drawn_start(path.state(path.begin()), options.start, start_noise);
  }

  const VehicleTrajectory& trajectory;
  SimulatedUnit unit;
  SimulatedRanges ranges;
  std::vector<WheelSpeed> wheels;
  GnssInsOptions filter;
  GnssInsStart start;
};

InsErrorSeries filtered(Run& run) {
  GnssIns filter(run.filter);
  filter.start(run.start);
  InsErrorSeries series;
  std::size_t k = 0, wheel = 0;
  for (ImuSample sample; run.unit.read(sample);) {
    const LogTime now = sample.time;
    (void)filter.add(sample);
    for (; wheel < run.wheels.size() && run.wheels[wheel].time <= now; ++wheel)
      (void)filter.add(run.wheels[wheel]);
    for (; k < run.ranges.epochs.size() && run.ranges.epochs[k].time <= now; ++k) {
      (void)filter.add(run.ranges.epochs[k]);
      if (run.ranges.epochs[k].time != now || !filter.started()) continue;
      const NisByKind nis = nis_by_kind(filter.take_innovations());
      if (k == 0) continue;  // these ranges initialise the clock
      series.push_back(error_at(filter.estimate(), run.trajectory.state(now), run.unit.errors(),
                                run.ranges.clocks[k]));
      series.back().nis = nis;
    }
  }
  return series;
}

InsErrorSeries smoothed(Run& run) {
  GnssInsRecording recording;
  recording.start = run.start;
  std::vector<std::pair<std::size_t, ImuErrors>> epochs;  // that coincide with a sample
  std::size_t k = 0;
  for (ImuSample sample; run.unit.read(sample);) {
    recording.imu.push_back(sample);
    while (k < run.ranges.epochs.size() && run.ranges.epochs[k].time < sample.time) ++k;
    if (k > 0 && k < run.ranges.epochs.size() && run.ranges.epochs[k].time == sample.time)
      epochs.emplace_back(k, run.unit.errors());
  }
  recording.ranges = run.ranges.epochs;
  recording.wheels = run.wheels;
  InsErrorSeries series;
  static_cast<void>(smooth_gnss_ins(recording, run.filter, {}, {}, [&](const GnssInsEstimate& e) {
    if (epochs.empty() || e.nav.time != run.ranges.epochs[epochs.back().first].time) return;
    series.push_back(error_at(e, run.trajectory.state(e.nav.time), epochs.back().second,
                              run.ranges.clocks[epochs.back().first]));
    epochs.pop_back();
  }));
  std::reverse(series.begin(), series.end());
  return series;
}

}  // namespace

InsErrorSeries ins_error_series(const VehicleTrajectory& trajectory,
                                const Constellation& constellation,
                                const InsMonteCarloOptions& options, const Rng& rng) {
  Run run(trajectory, constellation, options, rng);
  return options.smooth ? smoothed(run) : filtered(run);
}

std::vector<InsErrorSeries> ins_monte_carlo(const VehicleTrajectory& trajectory,
                                            const Constellation& constellation, std::size_t runs,
                                            const InsMonteCarloOptions& options, const Rng& rng,
                                            const std::function<void(double)>& progress) {
  std::vector<InsErrorSeries> all_series(runs);
  const auto one = [&](std::size_t r) {
    all_series[r] = ins_error_series(trajectory, constellation, options, rng.stream(r));
  };
  parallel_for(runs, options.threads, one, progress);
  return all_series;
}

}  // namespace wayfare::sim
