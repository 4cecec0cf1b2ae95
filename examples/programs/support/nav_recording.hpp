#pragma once

// Reads a recording of an inertial unit and a satellite receiver.

#include <functional>
#include <string>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/nav/gnss_ins.hpp>
#include <wayfare/ros/recording.hpp>
#include <wayfare/sensors/nav_state.hpp>

#include "nav_config.hpp"

namespace wayfare::examples {

/// Paths; empty if there is none.
struct NavFiles {
  std::vector<std::string> imu;  ///< one, or gyro and accelerometer
  std::string imu_tags;          ///< RTKLIB's time tags of the (first) file of the unit
  std::string imu_clock;         ///< pairs of the unit's times and GPS times
  std::string observations;
  std::vector<std::string> navigation;
  std::string ranges;
  std::string fixes;
  std::string truth;
  ros::TopicNames topics;  ///< of ROS recordings
};

struct NavRecording {
  GnssInsRecording recording;
  NavTrajectory truth;
  bool truth_has_velocity = false;
  bool truth_has_attitude = false;
  /// What was skipped, sorted or left out.
  std::vector<std::string> remarks;
};

/// Reads all files and sorts each stream by time. Errors: those of the readers; no satellite
/// measurements; streams that do not overlap in time, with the gap between them. Reports skipped
/// lines on standard error.
[[nodiscard]] Result<NavRecording> load_nav_recording(
    const NavFiles& files, const NavConfig& config,
    const std::function<void(double)>& progress = {});

}  // namespace wayfare::examples
