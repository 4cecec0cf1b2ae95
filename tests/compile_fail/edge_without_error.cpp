// EXPECT: an edge has a const member error
#include <wayfare/core/se2.hpp>
#include <wayfare/graph/factor_graph.hpp>

struct Compass {
  using Variables = wayfare::EdgeVariables<wayfare::SE2d>;
  static constexpr int kDim = 1;
#ifndef WAYFARE_MUST_FAIL
  Eigen::Matrix<double, 1, 1> error(const wayfare::SE2d& x) const {
    return Eigen::Matrix<double, 1, 1>(x.heading().radians());
  }
#endif
};

wayfare::FactorGraph<wayfare::Variables<wayfare::SE2d>, wayfare::Edges<Compass>> graph;
