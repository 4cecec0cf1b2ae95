#include "evaluate.hpp"

#include <algorithm>
#include <cmath>

#include <wayfare/eval/consistency.hpp>
#include <wayfare/sim/simulate_recording.hpp>

namespace wayfare::examples {
namespace {

double degrees(double radians) { return Angle::radians(radians).degrees(); }

}  // namespace

const char* name_of(Aiding aiding) {
  constexpr std::array<const char*, 5> kNames = {"without walls", "scan to scan", "side walls",
                                                 "and end walls", "side walls, marks"};
  return kNames[static_cast<std::size_t>(aiding)];
}

CorridorInsOptions options_for(const sim::CorridorDriveParams& p, Aiding aiding) {
  CorridorInsOptions o;
  o.walls.range_noise_m = p.lidar.range_noise_m;
  o.walls.flatness_m = 0.0003;  // simulated walls are flat, ranges have millimetre resolution
  o.noise.angle_random_walk_rad_per_sqrt_s = p.gyro.angle_random_walk_rad_per_sqrt_s;
  o.noise.bias_sigma_rad_s = p.gyro.walk_sigma_rad_s;
  o.noise.bias_tau_s = p.gyro.walk_tau_s;
  o.noise.slip_m_per_sqrt_m = p.slip_m_per_sqrt_m;
  o.noise.acceleration_sigma_m_s2 = 1e-7;  // wheels have errors of scale and slip only
  o.start_bias_rad_s = p.gyro.max_bias_rad_s / std::sqrt(3.0);
  o.start_drift_rad_s2 = std::max(p.gyro.drift_rad_s2, 1e-12);
  o.start_scale = p.speed_scale_sigma;
  o.start_position_m = 1e-4;
  o.latitude_rad = p.latitude_rad;
  o.gyro_range_rad_s = p.gyro.range_rad_s;
  o.use_walls = aiding != Aiding::none;
  o.use_end_walls = aiding == Aiding::end_walls;
  if (aiding == Aiding::scan_to_scan) o.memory = WallMemory::one_scan;
  if (aiding == Aiding::marks)
    o.marks_sigma_m = 0.1;  // errors of a mark's place are common to all its scans
  // Without walls the bias is that at rest, as in the source, without drift.
  if (aiding == Aiding::none) o.start_drift_rad_s2 = 1e-12;
  return o;
}

SE2d start_of(const CorridorInsOptions& options, const Rng& rng) {
  Rng own = rng.stream(9);
  const double x = own.normal(0.0, options.start_position_m);
  const double y = own.normal(0.0, options.start_position_m);
  return {x, y, Angle::radians(own.normal(0.0, options.start_heading_rad))};
}

double true_bias_at(const sim::CorridorDrive& drive, LogTime time) {
  const auto& gyro = drive.recording.gyro;
  const auto next = std::upper_bound(gyro.begin(), gyro.end(), time,
                                     [](LogTime t, const GyroSample& g) { return t < g.time; });
  const auto i = static_cast<std::size_t>(next - gyro.begin());
  return drive.gyro_bias_rad_s[i == 0 ? 0 : i - 1];
}

CorridorErrors errors_of(const CorridorRun& run, const sim::CorridorDrive& drive, double rest_s) {
  CorridorErrors e;
  std::array<double, 6> squares{}, counts{};
  double heading = 0.0, used = 0.0;
  std::size_t index = 0;
  // metres rolled per metre reported, minus one
  const double scale = 1.0 / (1.0 + drive.speed_scale) - 1.0;
  for (const CorridorEpoch& epoch : run.epochs) {
    used += epoch.update.outcome == WallOutcome::used ? 1.0 : 0.0;
    if (epoch.time.seconds() < rest_s) continue;
    const SE2d truth = sim::true_pose_at(drive.recording.truth, epoch.time);
    const Eigen::Vector2d d = epoch.pose.translation() - truth.translation();
    const double heading_error = (truth.inverse() * epoch.pose).heading().radians();
    const double bias = epoch.gyro_bias.value - true_bias_at(drive, epoch.time);
    for (const std::size_t section :
         {static_cast<std::size_t>(drive.section_at(epoch.time)), std::size_t{5}})
      squares[section] += d.squaredNorm(), counts[section] += 1.0;
    heading += heading_error * heading_error;
    e.end_m = d.norm();
    e.bias_error_deg_s = degrees(bias);
    if (index++ % 10 != 0) continue;
    Eigen::Matrix<double, 5, 1> error;
    error << d, heading_error, bias, epoch.speed_scale.value - scale;
    e.nees.push_back(eval::normalised_squared(error, epoch.joint_covariance));
  }
  for (std::size_t s = 0; s < squares.size(); ++s)
    e.position_rmse_m[s] = std::sqrt(squares[s] / counts[s]);
  const CorridorEpoch& last = run.epochs.back();
  e.heading_rmse_deg = degrees(std::sqrt(heading / counts[5]));
  e.bias_sigma_deg_s = degrees(last.gyro_bias.sigma);
  e.scale_error = last.speed_scale.value - scale;
  e.scale_sigma = last.speed_scale.sigma;
  e.along_sigma_m = std::sqrt(last.pose_covariance(0, 0));  // the last corridor lies along x
  e.across_sigma_m = std::sqrt(last.pose_covariance(1, 1));
  e.walls_share = used / static_cast<double>(run.epochs.size());
  return e;
}

}  // namespace wayfare::examples
