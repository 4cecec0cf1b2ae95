#pragma once

// Allocations of the program that fail when asked to.

#include <atomic>

namespace wayfare::tests {

/// Allocations until one fails, and then how many until the next; negative: none fails.
extern std::atomic<long> failing_in, failing_every;
/// How many there were.
extern std::atomic<long> allocations;

/// Allocations fail in its life where it is meant to; nothing fails outside.
class Failures {
 public:
  Failures(long in, long every) {
    failing_every = every;
    failing_in = in;
  }
  ~Failures() { failing_in = -1; }
  Failures(const Failures&) = delete;
  Failures& operator=(const Failures&) = delete;
};

}  // namespace wayfare::tests
