#pragma once

// Simulated worlds, robots, vehicles and walkers with their sensors.

#include <wayfare/sim/floor_plan.hpp>
#include <wayfare/sim/gnss.hpp>
#include <wayfare/sim/ins_monte_carlo.hpp>
#include <wayfare/sim/radar.hpp>
#include <wayfare/sim/robot_geometry.hpp>
#include <wayfare/sim/simulate_recording.hpp>
#include <wayfare/sim/vehicle_trajectory.hpp>
#include <wayfare/sim/walkers.hpp>
#include <wayfare/sim/walks.hpp>
#include <wayfare/sim/worlds.hpp>
