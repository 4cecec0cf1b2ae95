#pragma once

// LinearSolver on SuiteSparse's CHOLMOD. Needs the component wayfare::cholmod; CHOLMOD's supernodal
// module, which this uses, is GPL.

#include <cstddef>

#include <Eigen/CholmodSupport>

#include <wayfare/graph/scalar_solver.hpp>

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

  /// visit(column, l_jj²) for every pivot of L.
  template <class Visit>
  void each_pivot(Visit visit) const {
    const cholmod_factor& l = *this->m_cholmodFactor;
    const auto pivot = [&](int column, double root) { visit(column, root * root); };
    const auto* const order = static_cast<const int*>(l.Perm);
    const auto* const values = static_cast<const double*>(l.x);
    if (l.is_super == 0) {
      const auto* const starts = static_cast<const int*>(l.p);
      for (std::size_t j = 0; j < l.n; ++j) pivot(order[j], values[starts[j]]);
      return;
    }
    const auto* const firsts = static_cast<const int*>(l.super);
    const auto* const row_starts = static_cast<const int*>(l.pi);
    const auto* const value_starts = static_cast<const int*>(l.px);
    for (std::size_t s = 0; s < l.nsuper; ++s) {
      const int rows = row_starts[s + 1] - row_starts[s];
      for (int j = firsts[s]; j < firsts[s + 1]; ++j)
        pivot(order[j], values[value_starts[s] + (j - firsts[s]) * (rows + 1)]);
    }
  }
};

}  // namespace detail

/// Supernodal or simplicial Cholesky, by CHOLMOD's own choice.
template <int N>
using CholmodSolver = ScalarSolver<N, detail::OrderedCholmod<typename ScalarExpansion<N>::Matrix>>;

static_assert(LinearSolver<CholmodSolver<3>> && LinearSolver<CholmodSolver<6>>);

}  // namespace wayfare
