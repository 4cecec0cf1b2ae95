// EXPECT: PlanarSweepMotion
#include <wayfare/sensors/deskew.hpp>

struct Turn {
#ifdef WAYFARE_MUST_FAIL
  double operator()(wayfare::LogTime time) const { return 0.5 * time.seconds(); }
#else
  wayfare::SE2d operator()(wayfare::LogTime time) const {
    return wayfare::SE2d(0.0, 0.0, wayfare::Angle::radians(0.5 * time.seconds()));
  }
#endif
};

bool undone(const wayfare::LaserScan& scan, wayfare::LaserScan& instant) {
  return wayfare::deskew(scan, Turn{}, scan.time, instant).has_value();
}
