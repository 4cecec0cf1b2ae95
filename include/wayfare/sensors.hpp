#pragma once

// What devices measure, as plain values: inertial, magnetic, laser, radar, GNSS and wheel
// measurements, point sets, recordings and trajectories.

#include <wayfare/sensors/deskew.hpp>
#include <wayfare/sensors/measurements.hpp>
#include <wayfare/sensors/point_set.hpp>
#include <wayfare/sensors/pose_history.hpp>
#include <wayfare/sensors/recording.hpp>
#include <wayfare/sensors/scans.hpp>
#include <wayfare/sensors/trajectory.hpp>
