#pragma once

// Factorisation of fronts by several threads. A front sums its own columns and its children's
// updates in the order of the plan, so results do not depend on the number of threads.

#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

#include "graph/cholesky/symbolic.hpp"

namespace wayfare::cholesky {

/// The tree of fronts, partitioned into tasks: fronts [begins[t], begins[t + 1]) are task t.
struct TaskTree {
  std::vector<int> begins;
  std::vector<int> parents;          ///< of each task, −1 for none; children come before parents
  std::vector<double> cost_to_root;  ///< total cost of the task and all tasks above it

  [[nodiscard]] int size() const { return static_cast<int>(parents.size()); }
};

/// One task for one thread or little work. Otherwise small subtrees, adjacent ones together, and
/// each front above them on its own, independently of the number of threads. A front's children are
/// either all in its own task or all in tasks below.
[[nodiscard]] TaskTree share_out(const FrontPlan& plan, int threads);

/// Threads that execute the tasks of a tree and wait between calls of `run`.
class TaskPool {
 public:
  /// At most `threads`, including the caller's, limited by the number of tasks and the system.
  TaskPool(TaskTree tree, int threads);
  ~TaskPool();
  TaskPool(const TaskPool&) = delete;
  TaskPool& operator=(const TaskPool&) = delete;

  /// Calls task(t) once for each task, after all its children; returns when all are done. Does not
  /// allocate.
  void run(const std::function<void(int)>& task);

 private:
  void work(std::unique_lock<std::mutex>& lock, const auto& done);
  void make_ready(int task);
  [[nodiscard]] auto shorter() const {
    return [this](int a, int b) { return tree_.cost_to_root[at(a)] < tree_.cost_to_root[at(b)]; };
  }

  TaskTree tree_;     // constant
  std::mutex mutex_;  // guards all below
  std::condition_variable changed_;
  const std::function<void(int)>* task_ = nullptr;
  std::vector<int> ready_;  // a heap, greatest cost_to_root first
  std::vector<int> children_left_;
  int remaining_ = 0;
  bool stopping_ = false;
  std::vector<std::thread> workers_;
};

}  // namespace wayfare::cholesky
