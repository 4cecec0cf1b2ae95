// EXPECT: kJoinsTheseVariables
#include <wayfare/graph/edges.hpp>
#include <wayfare/graph/factor_graph.hpp>

void run() {
  using namespace wayfare;
  FactorGraph<Variables<SE2d, Eigen::Vector2d>, Edges<Between<SE2d>>> graph;
  const auto pose = graph.add(SE2d());
#ifdef WAYFARE_MUST_FAIL
  const auto other = graph.add(Eigen::Vector2d(1.0, 0.0));
#else
  const auto other = graph.add(SE2d());
#endif
  graph.add(Between<SE2d>{SE2d()}, pose, other);
}
