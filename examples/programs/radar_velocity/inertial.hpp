#pragma once

// Radar-inertial odometry of the frames' velocities, with how it agrees with itself.

#include <optional>
#include <string>
#include <vector>

#include <wayfare/inertial/radar_inertial_odometry.hpp>
#include <wayfare/io/report.hpp>
#include <wayfare/motion/radar_velocity.hpp>

#include "ahrs/recording.hpp"
#include "support/program_files.hpp"
#include "support/slam_program.hpp"

namespace wayfare::examples {

struct InertialOptions {
  bool use = false;
  UnitOptions unit;
  std::vector<double> rotation, lever;  ///< of the radar on the unit
  double radar_delay_s = 0.0;

  void add_options(CommandLine& app);
};

struct InertialResult {
  RadarInertialRun forward, backward;
  double gyro_bias_degps = 0.0;
  Facts facts;
};

/// Errors: no readings of the unit, none at the time of the radar, options that are no rotation.
[[nodiscard]] Result<InertialResult> run_inertial(const InertialOptions& options,
                                                  const SlamArguments& arguments,
                                                  std::vector<RadarVelocity> velocities);
[[nodiscard]] Result<void> write_path(const InertialResult& result, const std::string& path,
                                      const io::WriteOptions& options);
void add_plots(const InertialResult& result, io::Report& report);

}  // namespace wayfare::examples
