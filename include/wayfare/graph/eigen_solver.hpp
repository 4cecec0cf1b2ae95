#pragma once

#include <Eigen/SparseCholesky>

#include <wayfare/graph/detail/scalar_solver.hpp>

namespace wayfare {

/// LinearSolver on Eigen's simplicial Cholesky. Without further dependencies; slow for large blocks
/// or much fill-in (3D graphs).
template <int N>
using EigenSolver =
    ScalarSolver<N, Eigen::SimplicialLLT<typename ScalarExpansion<N>::Matrix, Eigen::Upper,
                                         Eigen::NaturalOrdering<int>>>;

static_assert(LinearSolver<EigenSolver<3>> && LinearSolver<EigenSolver<6>>);

// Compiled once in wayfare::graph.
extern template class ScalarSolver<
    3, Eigen::SimplicialLLT<ScalarExpansion<3>::Matrix, Eigen::Upper, Eigen::NaturalOrdering<int>>>;
extern template class ScalarSolver<
    6, Eigen::SimplicialLLT<ScalarExpansion<6>::Matrix, Eigen::Upper, Eigen::NaturalOrdering<int>>>;

}  // namespace wayfare
