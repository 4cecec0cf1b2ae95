#pragma once

// A recorded drive: car, MEMS unit at 100 Hz, fixed RTK positions at 4 Hz
// (rtklibexplorer/GNSS_IMU). Without raw observations, ranges are simulated from the RTK positions.

#include <filesystem>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/core/so3.hpp>
#include <wayfare/io/nav_text.hpp>
#include <wayfare/nav/gnss_ins.hpp>
#include <wayfare/sim/gnss.hpp>

namespace wayfare::tests {

inline std::string drive_0708_folder() { return WAYFARE_DATA_DIR "/gnss/drive_0708"; }

struct Drive0708 {
  std::vector<ImuSample> imu;
  NavTrajectory
      antenna;  ///< the RTK solution; its velocities are means of the quarter second before
};

inline Result<Drive0708> load_drive_0708() {
  const std::string imu_file = drive_0708_folder() + "/imu_1934.csv.gz";
  const auto imu = io::read_imu(
      imu_file, {{"ax_g", "ay_g", "az_g", "gx_degps", "gy_degps", "gz_degps", "t_ms"}});
  if (!imu) return imu.error();
  const auto tags = io::read_time_tags(drive_0708_folder() + "/imu_1934.csv.tag.gz");
  if (!tags) return tags.error();
  const auto clock = io::fit_time_tags(*imu, *tags);
  if (!clock) return clock.error();
  auto solution = io::read_nav(drive_0708_folder() + "/gnss_1934_sf.pos.gz");
  if (!solution) return solution.error();
  Drive0708 drive{imu->samples, std::move(solution->trajectory)};
  for (ImuSample& s : drive.imu) s.time = (*clock)(s.time);
  return drive;
}

/// Antenna position at any time.
inline Result<sim::VehicleTrajectory> antenna_trajectory(const Drive0708& drive) {
  sim::TrackFit fit;
  fit.velocity_late_s = 0.13;
  return sim::follow_solution(drive.antenna, fit);
}

/// Eight satellites, 2 m and 0.1 m/s.
inline sim::SimulatedRanges simulated_ranges(const sim::VehicleTrajectory& antenna,
                                             std::uint64_t seed) {
  sim::RangeParams params;
  params.max_satellites = 8;
  return sim::simulate_ranges(antenna, sim::gps_and_galileo(), params, Rng(seed));
}

/// Mounting, data sheet noise and time offset of the unit. The filter estimates the car's vibration
/// itself.
inline GnssInsOptions drive_0708_options() {
  constexpr double kDegree = std::numbers::pi / 180.0;
  GnssInsOptions o;
  o.q_body_imu = rotation_from_roll_pitch_yaw(kDegree * Eigen::Vector3d(-179.364, 6.760, -174.612));
  o.antenna_lever_arm_m = {0.0, -0.05, 0.0};
  o.imu_time_offset_s = -0.27;
  o.imu.gyro_white_rad_per_sqrt_s.setConstant(0.0038 * kDegree);
  o.imu.accel_white_mps_per_sqrt_s.setConstant(70e-6 * 9.80665);
  o.imu.gyro_bias_radps = {Eigen::Vector3d::Constant(0.2 * kDegree),
                           Eigen::Vector3d::Constant(1e5)};
  o.imu.accel_bias_mps2 = {Eigen::Vector3d::Constant(0.1), Eigen::Vector3d::Constant(1e5)};
  return o;
}

}  // namespace wayfare::tests
