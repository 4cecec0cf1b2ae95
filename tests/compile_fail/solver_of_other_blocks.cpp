// EXPECT: the blocks of the solver, kBlock, are as large as those of the graph
#include <wayfare/graph/optimise.hpp>

#ifdef WAYFARE_MUST_FAIL
using Solver = wayfare::MultifrontalCholesky<3>;
#else
using Solver = wayfare::MultifrontalCholesky<6>;
#endif

wayfare::PoseGraphOptimiser<wayfare::SE3d, Solver> optimiser;
