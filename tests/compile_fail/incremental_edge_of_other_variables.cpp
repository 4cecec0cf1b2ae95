// EXPECT: kJoinsTheseVariables
#include <wayfare/graph/edges.hpp>
#include <wayfare/graph/factor_graph.hpp>
#include <wayfare/graph/incremental.hpp>

using namespace wayfare;

using Graph = FactorGraph<Variables<SE2d, Eigen::Vector2d>, Edges<BearingRange>>;

Result<void> add(IncrementalGraphOptimiser<Graph>& growing, VariableId<SE2d> pose,
                 VariableId<Eigen::Vector2d> tree) {
#ifdef WAYFARE_MUST_FAIL
  return growing.add(BearingRange{}, tree, pose);
#else
  return growing.add(BearingRange{}, pose, tree);
#endif
}
