// EXPECT: matcher.make_map
#include <wayfare/slam/basic_graph_slam.hpp>

#include "matcher_that_stays.hpp"

static_assert(sizeof(wayfare::BasicGraphSlam<Stays>) > 0);
