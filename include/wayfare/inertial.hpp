#pragma once

// Strapdown mechanisation, INS state and model, AHRS, Allan deviation and calibration.

#include <wayfare/inertial/ahrs.hpp>
#include <wayfare/inertial/ahrs_parameters.hpp>
#include <wayfare/inertial/attitude.hpp>
#include <wayfare/inertial/imu_noise.hpp>
#include <wayfare/inertial/ins_measurements.hpp>
#include <wayfare/inertial/ins_model.hpp>
#include <wayfare/inertial/ins_state.hpp>
#include <wayfare/inertial/magnetometer_calibration.hpp>
#include <wayfare/inertial/radar_inertial_odometry.hpp>
