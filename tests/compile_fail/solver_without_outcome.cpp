// EXPECT: solver.factorise\(h\) } -> std::same_as<FactorOutcome>
#include <wayfare/graph/optimise.hpp>

struct Diagonal {
  static constexpr int kBlock = 3;
  Eigen::VectorXd inverse;
  void analyse(const wayfare::BlockSparse<3>&) {}
#ifdef WAYFARE_MUST_FAIL
  bool factorise(const wayfare::BlockSparse<3>&) { return true; }
#else
  wayfare::FactorOutcome factorise(const wayfare::BlockSparse<3>&) { return {}; }
#endif
  void solve_in_place(Eigen::VectorXd& x) { x = x.cwiseProduct(inverse); }
};

wayfare::PoseGraphOptimiser<wayfare::SE2d, Diagonal> optimiser;
