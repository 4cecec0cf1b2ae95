// EXPECT: a likelihood has a const member log_likelihood
#include <wayfare/slam/basic_localiser.hpp>

struct Line {
  wayfare::SE2d random_pose(wayfare::Rng& rng) const {
    return {rng.uniform(), 0.0, wayfare::Angle{}};
  }
};

struct Position {
#ifndef WAYFARE_MUST_FAIL
  double log_likelihood(const wayfare::SE2d& pose, double x_m, const Line&) const {
    return -(pose.x() - x_m) * (pose.x() - x_m);
  }
#endif
};

void localise(wayfare::BasicLocaliser<Line, Position>& localiser) {
  static_cast<void>(localiser.add_scan(wayfare::LogTime{}, 1.0, {}).has_value());
}
