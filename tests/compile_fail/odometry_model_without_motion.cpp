// EXPECT: a model of odometry has a const member motion
#include <wayfare/motion/odometry_model.hpp>

struct Exact {
#ifndef WAYFARE_MUST_FAIL
  auto motion(const wayfare::SE2d& increment) const {
    return [increment](const wayfare::SE2d& pose, wayfare::Rng&) { return pose * increment; };
  }
#endif
};

const auto sampler = wayfare::sampler_of_odometry(Exact{}, wayfare::SE2d{});
