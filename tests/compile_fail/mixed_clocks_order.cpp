// EXPECT: these times are on different clocks; convert one of them first
#include <wayfare/core/time.hpp>

bool earlier(wayfare::Time<wayfare::DeviceClock> device, wayfare::Time<wayfare::HostClock> host) {
  bool result = device < device && host < host;
#ifdef WAYFARE_MUST_FAIL
  result = device < host;
#endif
  return result;
}
