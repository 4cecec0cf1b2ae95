#include "other.hpp"

wayfare::SE2d turned(const wayfare::SE2d& pose, wayfare::Angle by) {
  return pose * wayfare::SE2d(0.0, 0.0, by);
}
