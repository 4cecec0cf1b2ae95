// EXPECT: a map for localisation has a const member random_pose
#include <wayfare/slam/basic_localiser.hpp>

struct Line {
#ifndef WAYFARE_MUST_FAIL
  wayfare::SE2d random_pose(wayfare::Rng& rng) const {
    return {rng.uniform(), 0.0, wayfare::Angle{}};
  }
#endif
};

struct Anything {
  double log_likelihood(const wayfare::SE2d&, double, const Line&) const { return 0.0; }
};

void start(wayfare::BasicLocaliser<Line, Anything>& localiser) { localiser.start_anywhere(); }
