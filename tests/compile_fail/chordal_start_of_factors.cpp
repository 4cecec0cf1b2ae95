// EXPECT: takes pose graphs only
#include <wayfare/graph/edges.hpp>
#include <wayfare/graph/factor_graph.hpp>
#include <wayfare/graph/pose_graph.hpp>

using namespace wayfare;

#ifdef WAYFARE_MUST_FAIL
using Graph = FactorGraph<Variables<SE2d>, Edges<Between<SE2d>>>;
#else
using Graph = PoseGraph2;
#endif

Result<void> start(Graph& graph) { return start_from_chordal(graph); }
