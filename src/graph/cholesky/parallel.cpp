#include "graph/cholesky/parallel.hpp"

#include <algorithm>
#include <limits>
#include <system_error>
#include <utility>

#include "graph/cholesky/supernodes.hpp"

namespace wayfare::cholesky {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Starting and waking threads and fetching what another one wrote should not be felt; it was where
/// a whole solution takes some ten milliseconds.
constexpr double kWorthThreads_ns = 4e6;
/// A subtree is a task of its own up to this part of all work: small enough to even out, large
/// enough for the handing out not to be felt.
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
  // Parents of subtrees side by side lie on one way to a root, that of the last one lowest.
  for (std::size_t t = 0; t < cost.size(); ++t) {
    const int parent = plan.fronts[at(tree.begins[t + 1] - 1)].parent;
    tree.parents.push_back(parent < 0 ? -1 : task_of[at(parent)]);
  }
  tree.ways = std::move(cost);
  for (std::size_t t = tree.ways.size(); t-- > 0;)
    if (tree.parents[t] >= 0) tree.ways[t] += tree.ways[at(tree.parents[t])];
  return tree;
}

TaskPool::TaskPool(TaskTree tree, int threads)
    : tree_(std::move(tree)), children_left_(at(tree_.size())) {
  ready_.reserve(at(tree_.size()));
  const int others = std::min(threads, tree_.size()) - 1;
  others_.reserve(at(std::max(others, 0)));
  try {
    for (int k = 0; k < others; ++k) others_.emplace_back([this] { serve(); });
  } catch (const std::system_error&) {  // no more to be had: the same bits, later
  }
}

TaskPool::~TaskPool() {
  {
    const std::lock_guard lock(mutex_);
    leaving_ = true;
  }
  changed_.notify_all();
  for (std::thread& thread : others_) thread.join();
}

void TaskPool::run(const std::function<void(int)>& task) {
  std::unique_lock lock(mutex_);
  task_ = &task;
  left_ = tree_.size();
  std::fill(children_left_.begin(), children_left_.end(), 0);
  for (const int parent : tree_.parents)
    if (parent >= 0) ++children_left_[at(parent)];
  for (int t = 0; t < tree_.size(); ++t)
    if (children_left_[at(t)] == 0) make_ready(t);
  changed_.notify_all();
  while (left_ > 0) {
    if (ready_.empty()) {
      changed_.wait(lock);
    } else {
      do_next(lock);
    }
  }
}

void TaskPool::serve() {
  std::unique_lock lock(mutex_);
  while (!leaving_) {
    if (ready_.empty()) {
      changed_.wait(lock);
    } else {
      do_next(lock);
    }
  }
}

// Nobody needs to be woken for a parent made ready here: its maker looks for work next.
void TaskPool::do_next(std::unique_lock<std::mutex>& lock) {
  std::pop_heap(ready_.begin(), ready_.end(), nearer());
  const int t = ready_.back();
  ready_.pop_back();
  const auto& task = *task_;
  lock.unlock();
  task(t);
  lock.lock();
  if (--left_ == 0) changed_.notify_all();
  if (const int parent = tree_.parents[at(t)]; parent >= 0 && --children_left_[at(parent)] == 0)
    make_ready(parent);
}

void TaskPool::make_ready(int task) {
  ready_.push_back(task);
  std::push_heap(ready_.begin(), ready_.end(), nearer());
}

}  // namespace wayfare::cholesky
