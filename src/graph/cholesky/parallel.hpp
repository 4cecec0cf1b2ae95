#pragma once

// Fronts by several threads. A front adds up its own columns and its children's updates in the
// order of the plan, whoever made them and when: the sums are the same for any number of threads.

#include <condition_variable>
#include <cstddef>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

#include "graph/cholesky/fronts.hpp"

namespace wayfare::cholesky {

/// The tree of fronts in larger parts: fronts [begins[t], begins[t + 1]) are task t.
struct TaskTree {
  std::vector<int> begins;
  std::vector<int> parents;  ///< of each task, −1 for none; children come before parents
  std::vector<double> ways;  ///< what it and all tasks above it cost one after another

  [[nodiscard]] int size() const { return static_cast<int>(parents.size()); }
};

/// One task for one thread or where there is little to do. Otherwise small subtrees, those side by
/// side together, and each front above them by itself; the number of threads has no say in it. A
/// front's children are all in its own task or all in others below that.
[[nodiscard]] TaskTree share_out(const FrontPlan& plan, int threads);

/// Threads that do the tasks of a tree and wait from one `run` to the next.
class TaskPool {
 public:
  /// As many of `threads` as there are tasks for and the system gives, the caller's among them.
  TaskPool(TaskTree tree, int threads);
  ~TaskPool();
  TaskPool(const TaskPool&) = delete;
  TaskPool& operator=(const TaskPool&) = delete;

  /// task(t) for each task once, after all its children, which it sees finished; returns when all
  /// are done. Takes no memory.
  void run(const std::function<void(int)>& task);

 private:
  void serve();
  void do_next(std::unique_lock<std::mutex>& lock);
  void make_ready(int task);
  [[nodiscard]] auto nearer() const {
    return [this](int a, int b) {
      return tree_.ways[static_cast<std::size_t>(a)] < tree_.ways[static_cast<std::size_t>(b)];
    };
  }

  TaskTree tree_;     // as it was given
  std::mutex mutex_;  // of all below
  std::condition_variable changed_;
  const std::function<void(int)>* task_ = nullptr;
  std::vector<int> ready_;  // a heap, those with the longest way first
  std::vector<int> children_left_;
  int left_ = 0;
  bool leaving_ = false;
  std::vector<std::thread> others_;
};

}  // namespace wayfare::cholesky
