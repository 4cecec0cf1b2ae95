#pragma once

// The linear solvers of this build.

#include <gtest/gtest.h>

#include <wayfare/graph/eigen_solver.hpp>
#include <wayfare/graph/linear_solver.hpp>
#ifdef WAYFARE_TEST_CHOLMOD
#include <wayfare/graph/cholmod_solver.hpp>
#endif

namespace wayfare {

#ifdef WAYFARE_TEST_CHOLMOD
using AllSolvers =
    ::testing::Types<MultifrontalCholesky<3>, MultifrontalCholesky<6>, EigenSolver<3>,
                     EigenSolver<6>, CholmodSolver<3>, CholmodSolver<6>>;
#else
using AllSolvers = ::testing::Types<MultifrontalCholesky<3>, MultifrontalCholesky<6>,
                                    EigenSolver<3>, EigenSolver<6>>;
#endif

}  // namespace wayfare
