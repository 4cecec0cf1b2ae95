// EXPECT: needs edges that may be outliers
#include <wayfare/graph/edges.hpp>
#include <wayfare/graph/factor_graph.hpp>
#include <wayfare/graph/gnc.hpp>

using namespace wayfare;

#ifdef WAYFARE_MUST_FAIL
using Sight = BearingRange;
#else
using Sight = Robust<BearingRange>;
#endif

Result<GncReport> solve(FactorGraph<Variables<SE2d, Eigen::Vector2d>, Edges<Sight>>& graph) {
  return optimise_gnc(graph);
}
