// EXPECT: matcher.make_map
#include <wayfare/slam/submap_slam.hpp>

#include "matcher_that_stays.hpp"

wayfare::BasicSubmapSlam<Stays> slam{Stays{}};
