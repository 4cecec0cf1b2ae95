#pragma once

// Lie groups, manifolds, frames, clocks, angles, Gaussians, results, contracts, random numbers,
// statistics, least squares, parallel loops and SIMD packs.

#include <wayfare/core/angle.hpp>
#include <wayfare/core/atmosphere.hpp>
#include <wayfare/core/contract.hpp>
#include <wayfare/core/dual.hpp>
#include <wayfare/core/finite.hpp>
#include <wayfare/core/frame.hpp>
#include <wayfare/core/gaussian.hpp>
#include <wayfare/core/gaussian_sampler.hpp>
#include <wayfare/core/geodesy.hpp>
#include <wayfare/core/jacobian.hpp>
#include <wayfare/core/levenberg_marquardt.hpp>
#include <wayfare/core/manifold.hpp>
#include <wayfare/core/pack.hpp>
#include <wayfare/core/parallel.hpp>
#include <wayfare/core/random.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/core/statistics.hpp>
#include <wayfare/core/time.hpp>
