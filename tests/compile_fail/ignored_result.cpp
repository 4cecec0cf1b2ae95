// EXPECT: nodiscard
#include <wayfare/core/result.hpp>

#ifdef WAYFARE_MUST_FAIL
#pragma GCC diagnostic error "-Wunused-result"
#endif

wayfare::Result<int> parse();

void run() {
#ifdef WAYFARE_MUST_FAIL
  parse();
#else
  (void)parse();
#endif
}
