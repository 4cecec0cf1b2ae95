// EXPECT: an instant has a unit: Time::from_seconds\(s\) or from_nanoseconds\(ns\)
#include <wayfare/sensors/scans.hpp>

void set(wayfare::LaserScan& scan, double seconds) {
#ifdef WAYFARE_MUST_FAIL
  scan.time = seconds;
#else
  scan.time = wayfare::LogTime::from_seconds(seconds);
#endif
}
