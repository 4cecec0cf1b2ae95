#pragma once

#include <string>
#include <vector>

#include <wayfare/core/frame.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/measure/laser_scan.hpp>

namespace wayfare {

/// Where dead reckoning says the robot is.
struct OdometrySample {
  LogTime time;
  Transform2<frame::Odom, frame::Base> T_odom_base;
};

/// A time-stamped pose of an estimated or reference trajectory.
struct StampedPose {
  LogTime time;
  Transform2<frame::Map, frame::Base> T_map_base;
};

using Trajectory = std::vector<StampedPose>;

/// A robot's recorded run in memory, whatever file it came from. Scans and odometry are each in
/// order of time; odometry may be empty.
struct Recording {
  Transform2<frame::Base, frame::Laser> T_base_laser;
  std::vector<LaserScan> scans;
  std::vector<OdometrySample> odometry;
};

}  // namespace wayfare
