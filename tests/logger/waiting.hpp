#pragma once

#include <chrono>
#include <thread>

namespace wayfare::testing {

/// Waits until `done`; false after `timeout`.
template <class Done>
bool wait_for(std::chrono::milliseconds timeout, Done done) {
  const auto until = std::chrono::steady_clock::now() + timeout;
  while (std::chrono::steady_clock::now() < until) {
    if (done()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return done();
}

}  // namespace wayfare::testing
