#pragma once

// Kalman filters on manifolds, Gauss-Markov states, covariance intersection, particle sets and the
// Rao-Blackwellised particle filter.

#include <wayfare/filter/covariance_intersection.hpp>
#include <wayfare/filter/ekf.hpp>
#include <wayfare/filter/gauss_markov.hpp>
#include <wayfare/filter/particles.hpp>
#include <wayfare/filter/rbpf.hpp>
#include <wayfare/filter/sequential_update.hpp>
