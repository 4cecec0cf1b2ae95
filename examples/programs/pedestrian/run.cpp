#include "run.hpp"

#include <cstddef>

#include <wayfare/pedestrian/foot_tracker.hpp>

namespace wayfare::examples {
namespace {

void update(const Progress& progress, std::size_t i, std::size_t n) {
  if (i % 4096 == 0) progress(static_cast<double>(i) / static_cast<double>(n));
}

std::string readings(const SensorReport& r) {
  return std::to_string(r.used) + " used, " + std::to_string(r.missing) + " missing, " +
         std::to_string(r.late) + " late, " + std::to_string(r.saturated) + " saturated";
}

}  // namespace

WalkRun run_steps(const MargRecording& samples, const PedestrianParameters& parameters,
                  const Progress& progress) {
  Pedestrian pedestrian(parameters);
  WalkRun run;
  const auto keep = [&](const PedestrianPose& p) {
    const Eigen::Vector2d sigma = p.covariance.diagonal().head<2>().cwiseSqrt();
    run.rows.push_back({p.time,
                        {p.position_m.x(), p.position_m.y(), 0.0},
                        p.heading,
                        {sigma.x(), sigma.y(), 0.0},
                        p.length_m,
                        p.step.interval_s,
                        0.0,
                        true});
  };
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const MargUpdateStatus status = pedestrian.add(samples[i], keep);
    if (status.accelerometer == UpdateStatus::used ||
        status.accelerometer == UpdateStatus::saturated)
      run.force.emplace_back(samples[i].time, samples[i].specific_force_mps2.norm());
    update(progress, i, samples.size());
  }
  const PedestrianReport report = pedestrian.report();
  run.events = report.steps;
  run.walked_m = report.distance_m;
  run.facts = {
      {"gyro", readings(report.ahrs.gyro)},
      {"accelerometer", readings(report.ahrs.accelerometer)},
      {"magnetometer", readings(report.ahrs.magnetometer) + ", " +
                           std::to_string(report.ahrs.magnetometer.disturbed) + " disturbed"},
      {"attitude restarts", std::to_string(report.ahrs.restarts)},
      {"steps without a heading", std::to_string(report.without_heading)}};
  return run;
}

WalkRun run_foot(const MargRecording& samples, const FootParameters& parameters,
                 const Progress& progress) {
  FootTracker tracker(parameters);
  WalkRun run;
  run.foot = true;
  Eigen::Vector3d last = Eigen::Vector3d::Zero();
  const auto keep = [&](const FootPose& p) {
    WalkRow row{p.time, p.position_m, p.heading,   p.position_covariance_m2.diagonal().cwiseSqrt(),
                0.0,    0.0,          p.statistic, p.stance > 0.5};
    if (row.event) {
      row.step_m = (p.position_m - last).head<2>().norm();
      run.walked_m += row.step_m;
      last = p.position_m;
    }
    run.rows.push_back(row);
  };
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const MargSample& s = samples[i];
    tracker.add({s.time, s.angular_rate_radps, s.specific_force_mps2}, keep);
    update(progress, i, samples.size());
  }
  tracker.finish(keep);
  const FootReport& report = tracker.report();
  run.events = report.stances;
  run.facts = {{"gyro", readings(report.gyro)},
               {"accelerometer", readings(report.accelerometer)},
               {"unreliable stances", std::to_string(report.rejected)},
               {"gaps", std::to_string(report.gaps)},
               {"reinitialised", std::to_string(report.lost)}};
  return run;
}

}  // namespace wayfare::examples
