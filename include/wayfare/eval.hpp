#pragma once

// Trajectory errors, alignment, consistency tests and tables.

#include <wayfare/eval/consistency.hpp>
#include <wayfare/eval/evaluation.hpp>
#include <wayfare/eval/nav_error.hpp>
#include <wayfare/eval/pose_consistency.hpp>
#include <wayfare/eval/relations.hpp>
#include <wayfare/eval/table.hpp>
#include <wayfare/eval/track_comparison.hpp>
#include <wayfare/eval/track_curve.hpp>
#include <wayfare/eval/trajectory_error.hpp>
