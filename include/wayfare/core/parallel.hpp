#pragma once

// Loops on several threads with the same result for any number.

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <functional>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

namespace wayfare {

/// Receives the fraction done, in (0, 1].
using FractionDone = std::function<void(double)>;

/// Calls f(index, worker) for the indices 0 … n-1, on up to `threads` threads, and `progress`, from
/// one thread at a time, after each. No two concurrent calls have the same worker, which is below
/// `threads`. The assignment of indices to threads is not specified: if f writes only to data of
/// its index or of its worker, the result does not depend on the number of threads. Fewer threads
/// are used where the system has no more, and never more than 256.
template <class F>
void parallel_for_workers(std::size_t n, int threads, const F& f,
                          const FractionDone& progress = {}) {
  constexpr int kMaxThreads = 256;
  const std::size_t workers =
      std::min(n, static_cast<std::size_t>(std::clamp(threads, 1, kMaxThreads)));
  std::atomic<std::size_t> next{0};
  std::size_t done = 0;
  std::mutex mutex;  // guards done and the calls of progress
  const auto work = [&](std::size_t worker) {
    for (std::size_t i = next++; i < n; i = next++) {
      f(i, worker);
      if (!progress) continue;
      const std::lock_guard lock(mutex);
      progress(static_cast<double>(++done) / static_cast<double>(n));
    }
  };
  std::vector<std::thread> others;
  others.reserve(workers);
#if defined(__cpp_exceptions)
  try {
    for (std::size_t k = 1; k < workers; ++k) others.emplace_back(work, k);
  } catch (const std::system_error&) {
    // The threads there are share the work.
  }
#else  // a system without threads to give ends the program
  for (std::size_t k = 1; k < workers; ++k) others.emplace_back(work, k);
#endif
  work(0);
  for (auto& thread : others) thread.join();
}

/// The same for calls f(index).
template <class F>
void parallel_for(std::size_t n, int threads, const F& f, const FractionDone& progress = {}) {
  parallel_for_workers(
      n, threads, [&](std::size_t i, std::size_t) { f(i); }, progress);
}

}  // namespace wayfare
