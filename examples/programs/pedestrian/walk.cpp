#include "walk.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>

#include <Eigen/Geometry>

#include <wayfare/eval/table.hpp>
#include <wayfare/pedestrian/foot_tracker.hpp>
#include <wayfare/pedestrian/pedestrian.hpp>

namespace wayfare::examples {
namespace {

void update(const WalkProgress& progress, std::size_t i, std::size_t n) {
  if (i % 4096 == 0) progress(static_cast<double>(i) / static_cast<double>(n));
}

struct PressureReading {
  LogTime time;
  double pressure_Pa = 0.0;
};

std::vector<PressureReading> pressure_readings(const io::MargFile& file) {
  std::vector<PressureReading> readings;
  for (std::size_t i = 0; i < file.pressure_Pa.size(); ++i) {
    const double p = file.pressure_Pa[i];
    if (std::isnan(p) || (!readings.empty() && readings.back().pressure_Pa == p)) continue;
    readings.push_back({file.samples[i].time, p});
  }
  std::stable_sort(readings.begin(), readings.end(),
                   [](const auto& a, const auto& b) { return a.time < b.time; });
  return readings;
}

/// Of a foot's rise from stance to stance: what its filter adds, but at least the deviation at
/// which it takes a floor as level.
double rise_variance(const WalkRow& stance, double previous_sigma_m) {
  const double level_m = FootParameters().level_sigma_m;
  const double sigma_m = stance.sigma_m.z();
  return std::max(level_m * level_m, sigma_m * sigma_m - previous_sigma_m * previous_sigma_m);
}

/// Afterwards the mean field of the whole walk is known.
void turn_to_final_north(std::vector<WalkRow>& rows) {
  for (WalkRow& row : rows) {
    const Angle turn = Angle::radians(rows.back().to_north_rad - row.to_north_rad);
    row.position_m.head<2>() = Eigen::Rotation2Dd(turn.radians()) * row.position_m.head<2>();
    row.heading = (row.heading + turn).wrapped();
  }
}

}  // namespace

std::string readings_text(const SensorReport& r) {
  return std::to_string(r.used) + " used, " + std::to_string(r.missing) + " missing, " +
         std::to_string(r.late) + " late, " + std::to_string(r.saturated) + " saturated";
}

WalkRun run_steps(const MargRecording& samples, const PedestrianParameters& parameters,
                  const WalkProgress& progress) {
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
    run.rows.back().to_north_rad = pedestrian.mean_field().correction();
    run.steps.push_back(p.step);
  };
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const MargUpdateStatus status = pedestrian.add(samples[i], keep);
    if (status.accelerometer == UpdateStatus::used ||
        status.accelerometer == UpdateStatus::saturated)
      run.force.emplace_back(samples[i].time, samples[i].specific_force_mps2.norm());
    update(progress, i, samples.size());
  }
  turn_to_final_north(run.rows);
  const PedestrianReport report = pedestrian.report();
  run.events = report.steps;
  run.walked_m = report.distance_m;
  run.facts = {
      {"gyro", readings_text(report.ahrs.gyro)},
      {"accelerometer", readings_text(report.ahrs.accelerometer)},
      {"magnetometer", readings_text(report.ahrs.magnetometer) + ", " +
                           std::to_string(report.ahrs.magnetometer.disturbed) + " disturbed"},
      {"attitude restarts", std::to_string(report.ahrs.restarts)},
      {"steps without a heading", std::to_string(report.without_heading)}};
  return run;
}

WalkRun run_foot(const MargRecording& samples, const FootParameters& parameters,
                 const WalkProgress& progress) {
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
  run.facts = {{"gyro", readings_text(report.gyro)},
               {"accelerometer", readings_text(report.accelerometer)},
               {"unreliable stances", std::to_string(report.rejected)},
               {"gaps", std::to_string(report.gaps)},
               {"reinitialised", std::to_string(report.lost)}};
  return run;
}

void add_heights(WalkRun& run, const io::MargFile& file,
                 const BarometricHeightParameters& parameters) {
  const auto readings = pressure_readings(file);
  run.pressure = !readings.empty();
  if (!run.pressure) return;
  BarometricHeight height(parameters);
  double nis = 0.0, last_m = 0.0, last_sigma_m = 0.0;
  auto next = readings.begin();
  const auto add = [&] {
    if (height.add(next->time, next->pressure_Pa) == UpdateStatus::used) nis += height.nis();
    ++next;
  };
  for (WalkRow& row : run.rows) {
    while (next != readings.end() && next->time < row.time) add();
    height.move(row.time, row.position_m.z() - last_m,
                run.foot && row.event ? rise_variance(row, last_sigma_m) : 0.0);
    last_m = row.position_m.z();
    if (row.event) last_sigma_m = row.sigma_m.z();
    if (next != readings.end() && next->time == row.time) add();
    row.pressure_height_m = height.by_pressure_m().value_or(0.0);
    row.height_m = height.height_m();
    row.height_sigma_m = height.sigma_m();
  }
  const SensorReport& report = height.report();
  std::string fact =
      std::to_string(report.used) + " used, " + std::to_string(report.missing) + " missing";
  if (report.used > 0)
    fact += ", mean normalised innovation squared " +
            eval::fixed(nis / static_cast<double>(report.used), 2);
  run.facts.emplace_back("barometer", fact);
}

}  // namespace wayfare::examples
