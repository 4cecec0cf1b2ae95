#pragma once

#include <wayfare/core/time.hpp>

namespace wayfare {

/// Distance rolled by each of two driven wheels since the previous sample, metres.
struct WheelSample {
  LogTime time;
  double left_m = 0.0;
  double right_m = 0.0;
};

/// The mean turn rate since the previous sample, counter-clockwise positive.
struct GyroSample {
  LogTime time;
  double turn_rate_rad_s = 0.0;
};

}  // namespace wayfare
