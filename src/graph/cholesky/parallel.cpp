#include "graph/cholesky/parallel.hpp"

#include <algorithm>
#include <limits>
#include <system_error>
#include <utility>

#include "graph/cholesky/symbolic.hpp"

namespace wayfare::cholesky {
namespace {

/// Below this the cost of starting and waking threads and of cache transfers was noticeable, in
/// solutions of some ten milliseconds.
constexpr double kWorthThreads_ns = 4e6;
/// Subtrees up to this fraction of the total work are single tasks: small enough to balance the
/// load, large enough for negligible overhead.
constexpr double kParts = 32.0;

}  // namespace

TaskTree share_out(const FrontPlan& plan, int threads) {
  const std::size_t n = plan.fronts.size();
  std::vector<double> own(n), whole(n, 0.0);  // of a front, with all below it
  double total = 0.0;
  for (std::size_t s = 0; s < n; ++s) {
    const Front& f = plan.fronts[s];
    own[s] = front_cost_ns(f.columns, f.rows, plan.block);
    whole[s] += own[s];
    total += own[s];
    if (f.parent >= 0) whole[at(f.parent)] += whole[s];
  }
  const double most = threads > 1 && total > kWorthThreads_ns
                          ? total / kParts
                          : std::numeric_limits<double>::infinity();
  TaskTree tree;
  std::vector<int> task_of(n);
  std::vector<double> cost;
  bool begin = true;
  for (std::size_t s = 0; s < n; ++s) {
    const bool above = whole[s] > most;
    if (begin || above) {
      tree.begins.push_back(static_cast<int>(s));
      cost.push_back(0.0);
    }
    task_of[s] = static_cast<int>(cost.size()) - 1;
    cost.back() += own[s];
    const int parent = plan.fronts[s].parent;
    const bool subtree_ends = parent < 0 || whole[at(parent)] > most;
    begin = above || (subtree_ends && cost.back() > most / 2.0);
  }
  tree.begins.push_back(static_cast<int>(n));
  // The parents of adjacent subtrees are on one path to a root, that of the last one lowest.
  for (std::size_t t = 0; t < cost.size(); ++t) {
    const int parent = plan.fronts[at(tree.begins[t + 1] - 1)].parent;
    tree.parents.push_back(parent < 0 ? -1 : task_of[at(parent)]);
  }
  tree.cost_to_root = std::move(cost);
  for (std::size_t t = tree.cost_to_root.size(); t-- > 0;)
    if (tree.parents[t] >= 0) tree.cost_to_root[t] += tree.cost_to_root[at(tree.parents[t])];
  return tree;
}

TaskPool::TaskPool(TaskTree tree, int threads)
    : tree_(std::move(tree)), children_left_(at(tree_.size())) {
  ready_.reserve(at(tree_.size()));
  const int workers = std::min(threads, tree_.size()) - 1;
  workers_.reserve(at(std::max(workers, 0)));
  try {
    for (int k = 0; k < workers; ++k)
      workers_.emplace_back([this] {
        std::unique_lock lock(mutex_);
        work(lock, [this] { return stopping_; });
      });
  } catch (const std::system_error&) {  // no more threads: same result, slower
  }
}

TaskPool::~TaskPool() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  for (std::thread& thread : workers_) thread.join();
}

void TaskPool::run(const std::function<void(int)>& task) {
  std::unique_lock lock(mutex_);
  task_ = &task;
  remaining_ = tree_.size();
  std::fill(children_left_.begin(), children_left_.end(), 0);
  for (const int parent : tree_.parents)
    if (parent >= 0) ++children_left_[at(parent)];
  for (int t = 0; t < tree_.size(); ++t)
    if (children_left_[at(t)] == 0) make_ready(t);
  changed_.notify_all();
  work(lock, [this] { return remaining_ == 0; });
}

// A parent that becomes ready here needs no notification: this thread looks for work next.
void TaskPool::work(std::unique_lock<std::mutex>& lock, const auto& done) {
  while (!done()) {
    if (ready_.empty()) {
      changed_.wait(lock);
      continue;
    }
    std::pop_heap(ready_.begin(), ready_.end(), shorter());
    const int t = ready_.back();
    ready_.pop_back();
    const auto& task = *task_;
    lock.unlock();
    task(t);
    lock.lock();
    if (--remaining_ == 0) changed_.notify_all();
    if (const int parent = tree_.parents[at(t)]; parent >= 0 && --children_left_[at(parent)] == 0)
      make_ready(parent);
  }
}

void TaskPool::make_ready(int task) {
  ready_.push_back(task);
  std::push_heap(ready_.begin(), ready_.end(), shorter());
}

}  // namespace wayfare::cholesky
