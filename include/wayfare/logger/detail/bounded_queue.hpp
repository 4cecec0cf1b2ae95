#pragma once

// Decouples threads that must not wait from one that may.

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <mutex>
#include <utility>

namespace wayfare::logger {

/// First in, first out, up to a total cost of `capacity` (bytes). Any thread may push; one thread
/// takes.
template <class T>
class BoundedQueue {
 public:
  explicit BoundedQueue(std::size_t capacity) : capacity_(capacity) {}

  /// False, without effect, if the queue is full.
  [[nodiscard]] bool push(T item, std::size_t cost) { return put(std::move(item), cost, false); }
  /// For the few items that must not be dropped.
  void push_always(T item) { put(std::move(item), 0, true); }

  /// All items; waits for the first up to `timeout`. Their cost counts until `done` is called.
  [[nodiscard]] std::deque<T> take(std::chrono::nanoseconds timeout) {
    std::unique_lock lock(mutex_);
    filled_.wait_for(lock, timeout, [&] { return !items_.empty(); });
    taken_ = waiting_;
    return std::exchange(items_, {});
  }
  /// The items taken last have been released.
  void done() {
    const std::lock_guard lock(mutex_);
    waiting_ -= std::exchange(taken_, 0);
  }

  [[nodiscard]] std::size_t cost() const {
    const std::lock_guard lock(mutex_);
    return waiting_;
  }
  [[nodiscard]] std::size_t peak() const {
    const std::lock_guard lock(mutex_);
    return peak_;
  }

 private:
  bool put(T item, std::size_t cost, bool always) {
    {
      const std::lock_guard lock(mutex_);
      if (!always && cost > capacity_ - std::min(capacity_, waiting_)) return false;
      waiting_ += cost;
      peak_ = std::max(peak_, waiting_);
      items_.push_back(std::move(item));
    }
    filled_.notify_one();
    return true;
  }

  const std::size_t capacity_;
  mutable std::mutex mutex_;
  std::condition_variable filled_;
  std::deque<T> items_;
  std::size_t waiting_ = 0, taken_ = 0, peak_ = 0;
};

}  // namespace wayfare::logger
