#pragma once

// Eigen's sparse Cholesky decomposition as a linear solver.

#include <Eigen/SparseCholesky>

#include <wayfare/graph/scalar_solver.hpp>

namespace wayfare {

namespace detail {

template <int N>
using OrderedLlt = Eigen::SimplicialLLT<typename ScalarExpansion<N>::Matrix, Eigen::Upper,
                                        Eigen::NaturalOrdering<int>>;

}  // namespace detail

/// LinearSolver on Eigen's simplicial Cholesky. Without further dependencies; slow for large blocks
/// or much fill-in (3D graphs).
template <int N>
using EigenSolver = ScalarSolver<N, detail::OrderedLlt<N>>;

static_assert(LinearSolver<EigenSolver<3>> && LinearSolver<EigenSolver<6>>);

// Compiled once in wayfare::graph.
extern template class ScalarSolver<3, detail::OrderedLlt<3>>;
extern template class ScalarSolver<6, detail::OrderedLlt<6>>;

}  // namespace wayfare
