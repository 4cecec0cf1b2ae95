#pragma once

// Occupancy grids, likelihood fields, distance fields, surface and NDT maps, ray casting.

#include <wayfare/map/cell.hpp>
#include <wayfare/map/distance_field.hpp>
#include <wayfare/map/inverse_lidar.hpp>
#include <wayfare/map/inverse_lidar_model.hpp>
#include <wayfare/map/likelihood_field.hpp>
#include <wayfare/map/ndt_map.hpp>
#include <wayfare/map/occupancy_grid.hpp>
#include <wayfare/map/probability_grid.hpp>
#include <wayfare/map/surface_map.hpp>
#include <wayfare/map/voxel_filter.hpp>
