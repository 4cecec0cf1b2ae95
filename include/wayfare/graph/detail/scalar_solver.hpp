#pragma once

#include <Eigen/Core>

#include <wayfare/graph/detail/scalar_expansion.hpp>
#include <wayfare/graph/linear_solver.hpp>
#include <wayfare/graph/multifrontal_cholesky.hpp>

namespace wayfare {

/// LinearSolver on a scalar decomposition with Eigen's interface (of the upper triangle of a
/// ScalarExpansion<N>::Matrix, without an ordering of its own), in the block ordering shared by all
/// solvers here. Such decompositions do not report where they failed; MultifrontalCholesky then
/// does.
template <int N, class Decomposition>
class ScalarSolver {
 public:
  static constexpr int kBlock = N;

  void analyse(const BlockSparse<N>& h);
  FactorOutcome factorise(const BlockSparse<N>& h);
  void solve_in_place(Eigen::VectorXd& x);

 private:
  ScalarExpansion<N> expansion_;
  Decomposition decomposition_;
  Eigen::VectorXd permuted_, solved_;
};

template <int N, class Decomposition>
void ScalarSolver<N, Decomposition>::analyse(const BlockSparse<N>& h) {
  expansion_.build(h, minimum_degree_order(h));
  decomposition_.analyzePattern(expansion_.matrix());
}

template <int N, class Decomposition>
FactorOutcome ScalarSolver<N, Decomposition>::factorise(const BlockSparse<N>& h) {
  expansion_.fill(h);
  decomposition_.factorize(expansion_.matrix());
  if (decomposition_.info() == Eigen::Success) return {};
  MultifrontalCholesky<N> blocks;
  blocks.analyse(h);
  return {false, blocks.factorise(h).block};
}

template <int N, class Decomposition>
void ScalarSolver<N, Decomposition>::solve_in_place(Eigen::VectorXd& x) {
  expansion_.permute(x, permuted_);
  solved_ = decomposition_.solve(permuted_);
  expansion_.unpermute(solved_, x);
}

}  // namespace wayfare
