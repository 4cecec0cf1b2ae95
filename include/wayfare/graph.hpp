#pragma once

// Pose graphs: optimisers, robust kernels, initialisation, covariances, incremental smoothing.

#include <wayfare/graph/edge.hpp>
#include <wayfare/graph/edges.hpp>
#include <wayfare/graph/eigen_solver.hpp>
#include <wayfare/graph/factor_graph.hpp>
#include <wayfare/graph/gnc.hpp>
#include <wayfare/graph/growing_factor_graph.hpp>
#include <wayfare/graph/incremental.hpp>
#include <wayfare/graph/linear_solver.hpp>
#include <wayfare/graph/loop_consistency.hpp>
#include <wayfare/graph/optimise.hpp>
#include <wayfare/graph/path_uncertainty.hpp>
#include <wayfare/graph/pose_graph.hpp>
#include <wayfare/graph/rank_check.hpp>
#include <wayfare/graph/report.hpp>
#include <wayfare/graph/robust_kernel.hpp>
#include <wayfare/graph/scalar_solver.hpp>
