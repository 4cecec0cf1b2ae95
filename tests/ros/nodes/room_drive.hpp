#pragma once

#include <vector>

#include <wayfare/ros/convert.hpp>
#include <wayfare/sensors/recording.hpp>

namespace wayfare::testing {

inline constexpr const char* kOdomFrame = "odom";

/// Round a simulated room, from second 1000 of the clock on; built once.
const Recording& room_drive();

/// The first ten seconds of a round with radar in a furnished room, by odometry, the same.
const Recording& radar_drive();

/// What a robot's own transforms say.
ros::TfMessage mounting(const Recording& recording);

}  // namespace wayfare::testing
