#pragma once

// Laws as test suites for types of your own; needs GoogleTest.

#include <wayfare/testing/decoder_laws.hpp>
#include <wayfare/testing/edge_laws.hpp>
#include <wayfare/testing/filter_laws.hpp>
#include <wayfare/testing/gate_laws.hpp>
#include <wayfare/testing/incremental_laws.hpp>
#include <wayfare/testing/kernel_laws.hpp>
#include <wayfare/testing/lie_group_laws.hpp>
#include <wayfare/testing/matcher_laws.hpp>
#include <wayfare/testing/particle_laws.hpp>
#include <wayfare/testing/pedestrian_laws.hpp>
#include <wayfare/testing/solver_laws.hpp>
#include <wayfare/testing/state_laws.hpp>
