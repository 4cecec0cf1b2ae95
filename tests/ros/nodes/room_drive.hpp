#pragma once

#include <vector>

#include <wayfare/ros/convert.hpp>
#include <wayfare/sensors/recording.hpp>

namespace wayfare::testing {

inline constexpr const char* kOdomFrame = "odom";

/// A drive round a simulated room, from second 1000 of the clock on; built once.
const Recording& room_drive();

/// The first ten seconds of a drive with radar in a furnished room, with odometry, likewise.
const Recording& radar_drive();

/// The robot's own transforms.
ros::TfMessage mounting(const Recording& recording);

}  // namespace wayfare::testing
