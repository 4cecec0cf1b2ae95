#include <wayfare/sim/ins_monte_carlo.hpp>

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

}  // namespace

InsErrorSeries ins_error_series(const VehicleTrajectory& trajectory,
                                const Constellation& constellation,
                                const InsMonteCarloOptions& options, const Rng& rng) {
  Rng start_noise = rng.stream(2);
  SimulatedUnit unit(trajectory, options.imu, rng.stream(0));
  const SimulatedRanges ranges =
      simulate_ranges(trajectory, constellation, options.ranges, rng.stream(1));
  GnssInsOptions filter_options = options.filter;
  filter_options.imu = options.imu.noise;
  filter_options.clock = options.ranges.clock;
  filter_options.q_body_imu = options.imu.q_body_imu;
  filter_options.antenna_lever_arm_m = options.ranges.antenna_lever_arm_m;
  GnssIns filter(filter_options);
  filter.start(drawn_start(trajectory.state(trajectory.begin()), options.start, start_noise));

  InsErrorSeries series;
  std::size_t k = 0;
  for (ImuSample sample; unit.read(sample);) {
    const LogTime now = sample.time;
    (void)filter.add(sample);
    for (; k < ranges.epochs.size() && ranges.epochs[k].time <= now; ++k) {
      (void)filter.add(ranges.epochs[k]);
      if (ranges.epochs[k].time != now || !filter.started()) continue;
      const NisByKind nis = nis_by_kind(filter.take_innovations());
      if (k == 0) continue;  // these ranges initialise the clock
      series.push_back(
          error_at(filter.estimate(), trajectory.state(now), unit.errors(), ranges.clocks[k]));
      series.back().nis = nis;
    }
  }
  return series;
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
