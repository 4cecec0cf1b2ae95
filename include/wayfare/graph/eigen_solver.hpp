#pragma once

#include <Eigen/SparseCholesky>

#include <wayfare/graph/linear_solver.hpp>
#include <wayfare/graph/scalar_expansion.hpp>

namespace wayfare {

/// LinearSolver on Eigen's column-by-column Cholesky. Small and everywhere available; slow where
/// blocks are large or fill is heavy (3D graphs).
template <int N>
class EigenSolver {
 public:
  static constexpr int kBlock = N;

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
  Eigen::SimplicialLLT<typename ScalarExpansion<N>::Matrix, Eigen::Upper,
                       Eigen::NaturalOrdering<int>>
      llt_;
  Eigen::VectorXd permuted_, solved_;
};

static_assert(LinearSolver<EigenSolver<3>> && LinearSolver<EigenSolver<6>>);

}  // namespace wayfare
