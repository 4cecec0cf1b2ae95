#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <thread>
#include <vector>

namespace wayfare {

/// Calls f(index, worker) for the indices 0 … n-1, on up to `threads` threads; no two calls at a
/// time have the same worker, which is below `threads`. Which takes which index is open, so f must
/// write only to what belongs to its index or its worker's scratch; the result is then the same for
/// any number.
template <class F>
void parallel_for_workers(std::size_t n, int threads, const F& f) {
  const std::size_t workers = std::min(n, static_cast<std::size_t>(std::max(threads, 1)));
  std::atomic<std::size_t> next{0};
  const auto work = [&](std::size_t worker) {
    for (std::size_t i = next++; i < n; i = next++) f(i, worker);
  };
  std::vector<std::thread> others;
  for (std::size_t k = 1; k < workers; ++k) others.emplace_back(work, k);
  work(0);
  for (auto& thread : others) thread.join();
}

/// The same for calls f(index).
template <class F>
void parallel_for(std::size_t n, int threads, const F& f) {
  parallel_for_workers(n, threads, [&](std::size_t i, std::size_t) { f(i); });
}

}  // namespace wayfare
