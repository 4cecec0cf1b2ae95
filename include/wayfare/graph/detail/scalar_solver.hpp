#pragma once

#include <optional>

#include <Eigen/Core>

#include <wayfare/graph/detail/scalar_expansion.hpp>
#include <wayfare/graph/linear_solver.hpp>
#include <wayfare/graph/multifrontal_cholesky.hpp>

namespace wayfare {

namespace detail {

/// visit(column, l_jj) for every pivot of L, columns as in the matrix that was factorised.
template <class Decomposition, class Visit>
void each_pivot(const Decomposition& decomposition, Visit visit) {
  if constexpr (requires { decomposition.each_pivot(visit); }) {
    decomposition.each_pivot(visit);
  } else {
    const auto& l = decomposition.matrixL().nestedExpression();
    const auto& from = decomposition.permutationPinv().indices();
    for (Eigen::Index j = 0; j < l.cols(); ++j)  // the diagonal comes first in its column
      visit(from.size() > 0 ? from[j] : static_cast<int>(j), l.valuePtr()[l.outerIndexPtr()[j]]);
  }
}

}  // namespace detail

/// LinearSolver on a scalar decomposition with Eigen's interface (of the upper triangle of a
/// ScalarExpansion<N>::Matrix, without an ordering of its own), in the block ordering shared by all
/// solvers here. Such decompositions test the signs of their pivots and do not report where they
/// failed. If they fail, or if a pivot is small relative to D, MultifrontalCholesky decides by
/// FactorOutcome's rule, at the cost of its factorisation.
template <int N, class Decomposition>
class ScalarSolver {
 public:
  static constexpr int kBlock = N;

  void analyse(const BlockSparse<N>& h);
  FactorOutcome factorise(const BlockSparse<N>& h);
  void solve_in_place(Eigen::VectorXd& x);

 private:
  [[nodiscard]] bool suspicious(const BlockSparse<N>& h) const;

  ScalarExpansion<N> expansion_;
  Decomposition decomposition_;
  std::optional<MultifrontalCholesky<N>> judge_;  // once it is asked
  Eigen::VectorXd permuted_, solved_;
};

template <int N, class Decomposition>
void ScalarSolver<N, Decomposition>::analyse(const BlockSparse<N>& h) {
  expansion_.build(h, minimum_degree_order(h));
  decomposition_.analyzePattern(expansion_.matrix());
  judge_.reset();
}

template <int N, class Decomposition>
FactorOutcome ScalarSolver<N, Decomposition>::factorise(const BlockSparse<N>& h) {
  expansion_.fill(h);
  decomposition_.factorize(expansion_.matrix());
  const bool solved = decomposition_.info() == Eigen::Success;
  if (solved && !suspicious(h)) return {};
  if (!judge_) judge_.emplace().analyse(h);
  FactorOutcome outcome = judge_->factorise(h);
  outcome.ok = outcome.ok && solved;
  return outcome;
}

/// Whether some pivot is small beside the diagonal it was before elimination.
template <int N, class Decomposition>
bool ScalarSolver<N, Decomposition>::suspicious(const BlockSparse<N>& h) const {
  const Eigen::VectorXd scale = expansion_.permuted_scales(h, kLeadingUnits<N>);
  const double loss = suspicious_loss(h.columns());
  bool found = false;
  detail::each_pivot(decomposition_, [&](int column, double pivot) {
    found = found || !(scale[column] <= loss * pivot * pivot);
  });
  return found;
}

template <int N, class Decomposition>
void ScalarSolver<N, Decomposition>::solve_in_place(Eigen::VectorXd& x) {
  expansion_.permute(x, permuted_);
  solved_ = decomposition_.solve(permuted_);
  expansion_.unpermute(solved_, x);
}

}  // namespace wayfare
