#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace wayfare::eval {

/// Calls run(0) … run(count − 1), on up to `threads` threads, and `progress` with the fraction done
/// after each. Which thread takes which run is open, so a run must write only to what is its own;
/// the outcome is then the same for any number of threads.
template <class Run>
void for_each_run(std::size_t count, int threads, const Run& run,
                  const std::function<void(double)>& progress = {}) {
  std::atomic<std::size_t> next{0};
  std::size_t done = 0;
  std::mutex mutex;
  const auto work = [&] {
    for (std::size_t i = next++; i < count; i = next++) {
      run(i);
      const std::lock_guard lock(mutex);
      ++done;
      if (progress) progress(static_cast<double>(done) / static_cast<double>(count));
    }
  };
  std::vector<std::thread> others;
  for (int t = 1; t < threads; ++t) others.emplace_back(work);
  work();
  for (auto& thread : others) thread.join();
}

}  // namespace wayfare::eval
