#pragma once

// Step detection, step length, pedestrian dead reckoning and foot-mounted inertial navigation.

#include <wayfare/pedestrian/barometric_height.hpp>
#include <wayfare/pedestrian/foot_tracker.hpp>
#include <wayfare/pedestrian/parameters.hpp>
#include <wayfare/pedestrian/pedestrian.hpp>
#include <wayfare/pedestrian/stance.hpp>
#include <wayfare/pedestrian/step.hpp>
#include <wayfare/pedestrian/step_detector.hpp>
#include <wayfare/pedestrian/two_feet.hpp>
#include <wayfare/pedestrian/walk_feedback.hpp>
