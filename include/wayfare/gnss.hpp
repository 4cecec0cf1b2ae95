#pragma once

// GNSS time, broadcast ephemerides, range corrections, range models and single-point positioning.

#include <wayfare/gnss/correct_ranges.hpp>
#include <wayfare/gnss/ephemerides.hpp>
#include <wayfare/gnss/gps_subframes.hpp>
#include <wayfare/gnss/gps_time.hpp>
#include <wayfare/gnss/phase_displacement.hpp>
#include <wayfare/gnss/range_model.hpp>
#include <wayfare/gnss/single_point.hpp>
