#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <thread>
#include <vector>

namespace wayfare {

/// Calls f(0) … f(n-1), on up to `threads` threads. Which thread takes which index is open, so f
/// must write only to what belongs to its index; the result is then the same for any number.
template <class F>
void parallel_for(std::size_t n, int threads, const F& f) {
  const std::size_t workers = std::min(n, static_cast<std::size_t>(std::max(threads, 1)));
  std::atomic<std::size_t> next{0};
  const auto work = [&] {
    for (std::size_t i = next++; i < n; i = next++) f(i);
  };
  std::vector<std::thread> others;
  for (std::size_t k = 1; k < workers; ++k) others.emplace_back(work);
  work();
  for (auto& thread : others) thread.join();
}

}  // namespace wayfare
