// EXPECT: an angle has a unit: Angle::radians\(x\) or Angle::degrees\(x\)
#include <wayfare/sensors/scans.hpp>

void set(wayfare::LaserScan& scan, double step) {
#ifdef WAYFARE_MUST_FAIL
  scan.bearing_step = step;
#else
  scan.bearing_step = wayfare::Angle::radians(step);
#endif
}
