#pragma once

#include <wayfare/graph/linear_solver.hpp>
#include <wayfare/graph/normal_equations.hpp>

namespace wayfare {

/// The covariance of two poses together (a first), as right perturbations of them: their rows and
/// columns of H⁻¹, zero for a fixed pose. `solver` has factorised `equations`' H.
template <LieGroup G, LinearSolver Solver>
[[nodiscard]] auto joint_covariance(const NormalEquations<G>& equations, Solver& solver, int a,
                                    int b) {
  constexpr int kDof = ManifoldTraits<G>::kDof;
  Eigen::Matrix<double, 2 * kDof, 2 * kDof> joint;
  joint.setZero();
  const int columns[2] = {equations.free_index(a), equations.free_index(b)};
  Eigen::VectorXd x(equations.gradient().size());
  for (int side = 0; side < 2; ++side) {
    if (columns[side] < 0) continue;
    for (int k = 0; k < kDof; ++k) {
      x.setZero();
      x[columns[side] * kDof + k] = 1.0;
      solver.solve_in_place(x);
      for (int row = 0; row < 2; ++row) {
        if (columns[row] < 0) continue;
        joint.template block<kDof, 1>(row * kDof, side * kDof + k) =
            x.template segment<kDof>(columns[row] * kDof);
      }
    }
  }
  return joint;
}

}  // namespace wayfare
