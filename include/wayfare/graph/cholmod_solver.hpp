#pragma once

// LinearSolver on SuiteSparse's CHOLMOD. Needs the component wayfare::cholmod; CHOLMOD's supernodal
// module, which this uses, is GPL.

#include <Eigen/CholmodSupport>

#include <wayfare/graph/linear_solver.hpp>
#include <wayfare/graph/scalar_expansion.hpp>

namespace wayfare {

/// Supernodal Cholesky where that pays, column by column where it does not (CHOLMOD's own choice),
/// in the block ordering all solvers here share.
template <int N>
class CholmodSolver {
 public:
  static constexpr int kBlock = N;

  CholmodSolver() {
    auto& settings = llt_.cholmod();
    settings.nmethods = 1;
    settings.method[0].ordering = CHOLMOD_NATURAL;  // the blocks are ordered already
    settings.postorder = 1;
    settings.print = 0;
    settings.final_ll = 1;  // a pivot that is not positive is an error, in either form
    llt_.setMode(Eigen::CholmodAuto);
  }

  void analyse(const BlockSparse<N>& h) {
    expansion_.build(h, minimum_degree_order(h));
    llt_.analyzePattern(expansion_.matrix());
  }

  FactorOutcome factorise(const BlockSparse<N>& h) {
    expansion_.fill(h);
    llt_.factorize(expansion_.matrix());
    return {llt_.info() == Eigen::Success, -1};
  }

  void solve_in_place(Eigen::VectorXd& x) {
    expansion_.permute(x, permuted_);
    solved_ = llt_.solve(permuted_);
    expansion_.unpermute(solved_, x);
  }

 private:
  ScalarExpansion<N> expansion_;
  Eigen::CholmodDecomposition<typename ScalarExpansion<N>::Matrix, Eigen::Upper> llt_;
  Eigen::VectorXd permuted_, solved_;
};

static_assert(LinearSolver<CholmodSolver<3>> && LinearSolver<CholmodSolver<6>>);

}  // namespace wayfare
