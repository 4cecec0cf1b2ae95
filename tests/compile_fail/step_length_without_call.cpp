// EXPECT: a step length model is a value with a const member
#include <wayfare/pedestrian/pedestrian.hpp>

struct ByHeight {
  double height_m = 1.75;
#ifndef WAYFARE_MUST_FAIL
  double operator()(const wayfare::Step&) const { return 0.41 * height_m; }
#endif
};

wayfare::BasicPedestrian<ByHeight> walker{wayfare::BasicPedestrianParameters<ByHeight>{}};
