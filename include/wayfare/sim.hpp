#pragma once

// Simulated worlds, robots, vehicles and walkers with their sensors.

#include <wayfare/sim/corridors.hpp>
#include <wayfare/sim/differential_drive.hpp>
#include <wayfare/sim/feet.hpp>
#include <wayfare/sim/floor_plan.hpp>
#include <wayfare/sim/head_walk.hpp>
#include <wayfare/sim/imu.hpp>
#include <wayfare/sim/ins_monte_carlo.hpp>
#include <wayfare/sim/lidar_2d.hpp>
#include <wayfare/sim/observations.hpp>
#include <wayfare/sim/plan_map.hpp>
#include <wayfare/sim/radar.hpp>
#include <wayfare/sim/ranges.hpp>
#include <wayfare/sim/reflectors.hpp>
#include <wayfare/sim/simulate_recording.hpp>
#include <wayfare/sim/vehicle_trajectory.hpp>
#include <wayfare/sim/worlds.hpp>
