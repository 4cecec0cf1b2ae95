#pragma once

// Device clocks to host time, streams in order of time, scans accumulated over time.

#include <wayfare/sync/augmented_scans.hpp>
#include <wayfare/sync/clock_fit.hpp>
#include <wayfare/sync/in_order.hpp>
#include <wayfare/sync/odometry_track.hpp>
#include <wayfare/sync/radar_odometry.hpp>
#include <wayfare/sync/scan_deskewer.hpp>
