// EXPECT: these times are on different clocks; convert one of them first
#include <wayfare/core/time.hpp>

void difference(wayfare::LogTime log, wayfare::Time<wayfare::GpsClock> gps) {
  (void)(log - log);
  (void)gps;
#ifdef WAYFARE_MUST_FAIL
  (void)(log - gps);
#endif
}
