#pragma once

#include <cstdio>

#include <wayfare/core/result.hpp>

namespace wayfare::examples {

/// 0, or 1 where a program failed, which it then says on standard error.
inline int exit_code(const char* program, const Result<void>& done) {
  if (done) return 0;
  std::fprintf(stderr, "%s: %s\n", program, done.error().to_string().c_str());
  return 1;
}

}  // namespace wayfare::examples
