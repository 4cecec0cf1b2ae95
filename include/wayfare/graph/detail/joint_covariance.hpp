#pragma once

#include <wayfare/graph/detail/normal_equations.hpp>
#include <wayfare/graph/linear_solver.hpp>

namespace wayfare {

namespace detail {

/// Columns of H⁻¹, with one solve each.
template <int N, LinearSolver Solver>
void solve_joint(Solver& solver, const int (&columns)[2], Eigen::Index size,
                 Eigen::Matrix<double, 2 * N, 2 * N>& joint) {
  Eigen::VectorXd x(size);
  for (int side = 0; side < 2; ++side) {
    if (columns[side] < 0) continue;
    for (int k = 0; k < N; ++k) {
      x.setZero();
      x[columns[side] * N + k] = 1.0;
      solver.solve_in_place(x);
      for (int row = 0; row < 2; ++row) {
        if (columns[row] < 0) continue;
        joint.template block<N, 1>(row * N, side * N + k) = x.template segment<N>(columns[row] * N);
      }
    }
  }
}

/// From the solver's selected inverse; false if a block is missing there.
template <int N, LinearSolver Solver>
bool look_up_joint(const Solver& solver, const int (&columns)[2],
                   Eigen::Matrix<double, 2 * N, 2 * N>& joint) {
  if constexpr (SelectedInverse<Solver>) {
    Eigen::Matrix<double, N, N> block;
    for (int row = 0; row < 2; ++row) {
      for (int side = 0; side < 2; ++side) {
        if (columns[row] < 0 || columns[side] < 0) continue;
        if (!solver.inverse_block(columns[row], columns[side], block)) return false;
        joint.template block<N, N>(row * N, side * N) = block;
      }
    }
    return true;
  }
  return false;
}

}  // namespace detail

/// The joint covariance of two poses (a first), as right perturbations of them: their rows and
/// columns of H⁻¹, zero for a fixed pose. `solver` has factorised `equations`' H; blocks of its
/// selected inverse are looked up.
template <LieGroup G, LinearSolver Solver>
[[nodiscard]] auto joint_covariance(const NormalEquations<G>& equations, Solver& solver, int a,
                                    int b) {
  constexpr int kDof = ManifoldTraits<G>::kDof;
  Eigen::Matrix<double, 2 * kDof, 2 * kDof> joint;
  joint.setZero();
  const int columns[2] = {equations.free_index(a), equations.free_index(b)};
  if (detail::look_up_joint<kDof>(solver, columns, joint)) return joint;
  detail::solve_joint<kDof>(solver, columns, equations.gradient().size(), joint);
  return joint;
}

}  // namespace wayfare
