#pragma once

// Motion models of wheels, gyro and odometry, and ego-velocity by radar Doppler.

#include <wayfare/motion/differential_drive_model.hpp>
#include <wayfare/motion/motion_noise.hpp>
#include <wayfare/motion/odometry_model.hpp>
#include <wayfare/motion/radar_velocity.hpp>
