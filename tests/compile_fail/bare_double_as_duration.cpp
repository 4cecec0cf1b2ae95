// EXPECT: (no match|invalid operands)
#include <wayfare/core/time.hpp>

wayfare::LogTime later(wayfare::LogTime t, double seconds) {
#ifdef WAYFARE_MUST_FAIL
  return t + seconds;
#else
  return t + wayfare::from_seconds(seconds);
#endif
}
