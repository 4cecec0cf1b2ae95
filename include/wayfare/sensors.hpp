#pragma once

// What devices measure, as plain values: inertial, magnetic, laser, radar, GNSS and wheel
// measurements, point sets, recordings and trajectories.

#include <wayfare/sensors/gnss.hpp>
#include <wayfare/sensors/imu.hpp>
#include <wayfare/sensors/laser_scan.hpp>
#include <wayfare/sensors/nav_state.hpp>
#include <wayfare/sensors/point_set.hpp>
#include <wayfare/sensors/radar_scan.hpp>
#include <wayfare/sensors/recording.hpp>
#include <wayfare/sensors/trajectory.hpp>
#include <wayfare/sensors/wheels.hpp>
