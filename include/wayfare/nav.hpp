#pragma once

// GNSS/INS with diagnosis of its data, corridor-aided inertial navigation, and outage experiments.

#include <wayfare/nav/check_drive.hpp>
#include <wayfare/nav/corridor_ins.hpp>
#include <wayfare/nav/gnss_ins.hpp>
#include <wayfare/nav/ins_filter.hpp>
#include <wayfare/nav/odometer.hpp>
#include <wayfare/nav/outage.hpp>
#include <wayfare/nav/phase_change.hpp>
#include <wayfare/nav/travel_direction.hpp>
