// EXPECT: a heading is an Angle: write 0.3_rad or Angle::degrees\(17\)
#include <wayfare/core/se2.hpp>

using namespace wayfare::literals;

wayfare::SE2d pose() {
#ifdef WAYFARE_MUST_FAIL
  return wayfare::SE2d(1.0, 2.0, 0.3);
#else
  return wayfare::SE2d(1.0, 2.0, 0.3_rad);
#endif
}
