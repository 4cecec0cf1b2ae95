#pragma once

// Kalman filters on manifolds, states composed of blocks, covariance intersection, particle filters
// on manifolds and the Rao-Blackwellised particle filter.

#include <wayfare/filter/blocks.hpp>
#include <wayfare/filter/covariance_intersection.hpp>
#include <wayfare/filter/ekf.hpp>
#include <wayfare/filter/gate.hpp>
#include <wayfare/filter/gates.hpp>
#include <wayfare/filter/gauss_markov.hpp>
#include <wayfare/filter/measurement.hpp>
#include <wayfare/filter/particle_filter.hpp>
#include <wayfare/filter/particles.hpp>
#include <wayfare/filter/pose_bins.hpp>
#include <wayfare/filter/process.hpp>
#include <wayfare/filter/process_model.hpp>
#include <wayfare/filter/rbpf.hpp>
#include <wayfare/filter/sequential_update.hpp>
#include <wayfare/filter/smoother.hpp>
#include <wayfare/filter/state.hpp>
