#pragma once

// LinearSolver on SuiteSparse's CHOLMOD. Needs the component wayfare::cholmod; CHOLMOD's supernodal
// module, which this uses, is GPL.

#include <Eigen/CholmodSupport>

#include <wayfare/graph/detail/scalar_solver.hpp>

namespace wayfare {

namespace detail {

/// CHOLMOD without reordering.
template <class Matrix>
class OrderedCholmod : public Eigen::CholmodDecomposition<Matrix, Eigen::Upper> {
 public:
  OrderedCholmod() {
    auto& settings = this->cholmod();
    settings.nmethods = 1;
    settings.method[0].ordering = CHOLMOD_NATURAL;
    settings.postorder = 1;
    settings.print = 0;
    settings.final_ll = 1;  // a pivot that is not positive is an error, simplicial or supernodal
    this->setMode(Eigen::CholmodAuto);
  }
};

}  // namespace detail

/// Supernodal or simplicial Cholesky, by CHOLMOD's own choice.
template <int N>
using CholmodSolver = ScalarSolver<N, detail::OrderedCholmod<typename ScalarExpansion<N>::Matrix>>;

static_assert(LinearSolver<CholmodSolver<3>> && LinearSolver<CholmodSolver<6>>);

}  // namespace wayfare
