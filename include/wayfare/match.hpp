#pragma once

// Scan matchers, the proposal density of a match, and line extraction.

#include <wayfare/match/correlative.hpp>
#include <wayfare/match/gauss_newton.hpp>
#include <wayfare/match/lines.hpp>
#include <wayfare/match/pose_proposal.hpp>
#include <wayfare/match/registration.hpp>
#include <wayfare/match/scan_matcher.hpp>
