#pragma once

// Graph, Hector, submap, radar and pedestrian SLAM, and Monte-Carlo localisation.

#include <wayfare/slam/basic_graph_slam.hpp>
#include <wayfare/slam/basic_localiser.hpp>
#include <wayfare/slam/graph_slam.hpp>
#include <wayfare/slam/hector_slam.hpp>
#include <wayfare/slam/localisation.hpp>
#include <wayfare/slam/monte_carlo.hpp>
#include <wayfare/slam/pedestrian_slam.hpp>
#include <wayfare/slam/radar_slam.hpp>
#include <wayfare/slam/radar_slam_options.hpp>
#include <wayfare/slam/robot_calibration.hpp>
#include <wayfare/slam/run_localisation.hpp>
#include <wayfare/slam/scan_likelihood.hpp>
#include <wayfare/slam/scan_outcome.hpp>
#include <wayfare/slam/submap_slam.hpp>
