#pragma once

// A recording of an inertial unit and a satellite receiver, from its files.

#include <functional>
#include <string>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/nav/gnss_ins.hpp>
#include <wayfare/ros/recording.hpp>
#include <wayfare/sensors/nav_state.hpp>

#include "nav_config.hpp"

namespace wayfare::examples {

/// Paths; empty where there is none.
struct NavFiles {
  std::vector<std::string> imu;  ///< one, or one for gyro and one for accelerometer
  std::string imu_tags;          ///< RTKLIB's time tags of the (first) file of the unit
  std::string imu_clock;         ///< stamps on the unit's clock and in GPS time
  std::string observations;
  std::vector<std::string> navigation;
  std::string ranges;
  std::string fixes;
  std::string truth;
  ros::TopicNames topics;  ///< of ROS recordings among them
};

struct NavRecording {
  GnssInsRecording recording;
  NavTrajectory truth;
  bool truth_has_velocity = false;
  bool truth_has_attitude = false;
  /// What was skipped, put in order or left out, for people.
  std::vector<std::string> remarks;
};

/// Reads all of them and puts each stream in order of time. Errors: those of the readers; no
/// satellite measurement at all; streams that do not overlap in time, with the gap between them.
/// Skipped lines go to standard error.
[[nodiscard]] Result<NavRecording> load_nav_recording(
    const NavFiles& files, const NavConfig& config,
    const std::function<void(double)>& progress = {});

}  // namespace wayfare::examples
