// EXPECT: matcher.make_map
#include <wayfare/slam/hector_slam.hpp>

#include "matcher_that_stays.hpp"

wayfare::BasicHectorSlam<Stays> slam{Stays{}};
