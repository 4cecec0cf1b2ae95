// EXPECT: solver.solve_in_place\(x\)
#include <wayfare/graph/optimise.hpp>

struct Diagonal {
  static constexpr int kBlock = 3;
  Eigen::VectorXd inverse;
  void analyse(const wayfare::BlockSparse<3>&) {}
  wayfare::FactorOutcome factorise(const wayfare::BlockSparse<3>&) { return {}; }
#ifndef WAYFARE_MUST_FAIL
  void solve_in_place(Eigen::VectorXd& x) { x = x.cwiseProduct(inverse); }
#endif
};

wayfare::PoseGraphOptimiser<wayfare::SE2d, Diagonal> optimiser;
