#pragma once

#include <wayfare/core/time.hpp>

namespace wayfare {

/// What the encoders of two driven wheels counted since the sample before, metres rolled.
struct WheelSample {
  LogTime time;
  double left_m = 0.0;
  double right_m = 0.0;
};

/// The mean turn rate since the sample before, counter-clockwise positive.
struct GyroSample {
  LogTime time;
  double turn_rate_rad_s = 0.0;
};

}  // namespace wayfare
