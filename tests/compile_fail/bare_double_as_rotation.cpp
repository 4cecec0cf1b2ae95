// EXPECT: a heading is an Angle: write 0.3_rad or Angle::degrees\(17\)
#include <wayfare/core/se2.hpp>

wayfare::SO2d turn(double value) {
#ifdef WAYFARE_MUST_FAIL
  return wayfare::SO2d(value);
#else
  return wayfare::SO2d(wayfare::Angle::radians(value));
#endif
}
