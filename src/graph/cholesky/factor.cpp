#include "graph/cholesky/factor.hpp"

#include <algorithm>
#include <atomic>
#include <functional>
#include <limits>
#include <utility>

namespace wayfare::cholesky {

Factor::Factor(FrontPlan plan, int leading)
    : plan_(std::move(plan)), leading_(leading), kernels_(best_kernels(plan_.block)) {
  place_fronts();
  place_diagonal();
  set_threads(1);
  permuted_.resize(plan_.order.size() * at(plan_.block));
}

void Factor::place_fronts() {
  places_.resize(plan_.fronts.size());
  for (std::size_t s = 0; s < places_.size(); ++s) {
    const Front& f = plan_.fronts[s];
    Place& place = places_[s];
    const int p = f.columns * plan_.block, m = f.rows * plan_.block;
    // A single tile needs no padding.
    place.ld11 = p == plan_.block || p == 6 ? p : padded(p);
    place.ld21 = padded(m);
    place.l11 = factor_size_;
    place.l21 = factor_size_ + at(padded(place.ld11 * p));
    factor_size_ = place.l21 + at(place.ld21) * at(p);
    inverse_scratch_ = std::max(inverse_scratch_, at(padded(p)) * at(2 * p + m));
    most_scratch_ = std::max(most_scratch_, place.ld11 + place.ld21);
  }
}

void Factor::set_threads(int threads) {
  if (threads == threads_) return;
  threads_ = threads;
  tasks_ = share_out(plan_, threads);
  place_updates();
  pool_ = tasks_.size() > 1 ? std::make_unique<TaskPool>(tasks_, threads) : nullptr;
}

void Factor::place_updates() {
  std::vector<int> depth(places_.size(), 0);
  for (std::size_t s = places_.size(); s-- > 0;)
    if (const int p = plan_.fronts[s].parent; p >= 0) depth[s] = depth[at(p)] + 1;
  stack_size_ = 0;
  for (std::size_t t = 0; t < tasks_.parents.size(); ++t)
    place_updates(at(tasks_.begins[t]), at(tasks_.begins[t + 1]), depth);
}

// Children in other tasks have their own stacks, which are not reused.
void Factor::place_updates(std::size_t begin, std::size_t end, const std::vector<int>& depth) {
  std::size_t top[2] = {0, 0}, highest[2] = {0, 0};
  for (std::size_t s = begin; s < end; ++s) {
    const Front& f = plan_.fronts[s];
    std::size_t& own = top[depth[s] % 2];
    std::size_t& children = top[1 - depth[s] % 2];
    for (const int child : plan_.children[s])
      if (at(child) >= begin) children = std::min(children, places_[at(child)].update);
    places_[s].update = own;
    own += at(places_[s].ld21) * at(f.rows * plan_.block);
    highest[depth[s] % 2] = std::max(highest[depth[s] % 2], own);
  }
  for (std::size_t s = begin; s < end; ++s)
    places_[s].update += stack_size_ + (depth[s] % 2 == 1 ? highest[0] : 0);
  stack_size_ += highest[0] + highest[1];
}

Panel Factor::panel(std::size_t s, const AlignedDoubles& values) const {
  const Front& f = plan_.fronts[s];
  const Place& place = places_[s];
  return {values.data() + place.l11,
          values.data() + place.l21,
          f.columns * plan_.block,
          f.rows * plan_.block,
          place.ld11,
          place.ld21};
}

Update Factor::update_of(int child) const {
  const Front& f = plan_.fronts[at(child)];
  const Place& place = places_[at(child)];
  return {stack_.data() + place.update, place.ld21, plan_.runs.data() + f.runs_begin, f.pivot_runs,
          f.runs};
}

int Factor::factorise_front(std::size_t s, const double* h) {
  const Front& f = plan_.fronts[s];
  const Panel front = panel(s, values_);
  std::fill(front.l11, front.l21 + at(front.ld21) * at(front.pivots), 0.0);
  kernels_.scatter(plan_.placements.data() + f.placements_begin,
                   f.placements_end - f.placements_begin, h, front);
  for (const int child : plan_.children[s]) kernels_.add_to_panel(update_of(child), front);
  if (const int failed = kernels_.factorise(front); failed >= 0)
    return f.first + failed / plan_.block;
  if (loses_digits(s, h, front)) suspicious_.store(true, std::memory_order_relaxed);
  if (f.rows == 0) return -1;
  double* const update = stack_.data() + places_[s].update;
  kernels_.update(front, update, front.ld21);
  for (const int child : plan_.children[s])
    kernels_.add_to_update(update_of(child), update, front.ld21);
  return -1;
}

FactorOutcome Factor::factorise(const double* h, int threads) {
  set_threads(threads);
  return judge(h, eliminate(h));
}

/// Returns the original column at which H stops being positive definite, or −1.
int Factor::eliminate(const double* h) {
  values_.reserve(factor_size_);
  stack_.reserve(stack_size_);
  scratch_.reserve(at(most_scratch_));
  inverted_ = false;
  suspicious_ = false;
  constexpr int kNone = std::numeric_limits<int>::max();
  std::atomic<int> failed = kNone;  // the first column in elimination order
  const auto task = [&](int t) {
    for (int s = tasks_.begins[at(t)]; s < tasks_.begins[at(t + 1)]; ++s) {
      // Later fronts cannot be the first failure, and may lack an update.
      if (plan_.fronts[at(s)].first > failed.load(std::memory_order_relaxed)) return;
      const int column = factorise_front(at(s), h);
      if (column < 0) continue;
      int first = failed.load(std::memory_order_relaxed);
      while (column < first && !failed.compare_exchange_weak(first, column)) {
      }
      return;
    }
  };
  if (pool_) {
    pool_->run(std::cref(task));
  } else {
    for (int t = 0; t < tasks_.size(); ++t) task(t);
  }
  return failed == kNone ? -1 : plan_.order[at(failed)];
}

void Factor::solve_in_place(double* x) {
  double* const y = permuted_.data();
  const int columns = static_cast<int>(plan_.order.size());
  kernels_.gather(plan_.order.data(), columns, x, y);
  for (std::size_t s = 0; s < places_.size(); ++s) substitute(s, kernels_.forward, y);
  for (std::size_t s = places_.size(); s-- > 0;) substitute(s, kernels_.backward, y);
  kernels_.gather(plan_.number.data(), columns, y, x);
}

// Each front's Z₂₂ uses the memory of its update: its lifetime, from the parent to the front, is
// that of the update in reverse.
void Factor::invert() {
  inverse_.reserve(factor_size_);
  scratch_.reserve(inverse_scratch_);
  for (std::size_t s = places_.size(); s-- > 0;) {
    const Panel z = panel(s, inverse_);
    const double* const z22 = stack_.data() + places_[s].update;
    kernels_.invert(panel(s, values_), z, z22, scratch_.data());
    for (const int child : plan_.children[s])
      kernels_.gather_inverse(update_of(child), z, z22, stack_.data() + places_[at(child)].update);
  }
  inverted_ = true;
}

bool Factor::inverse_block(int row, int column, double* out) const {
  if (!inverted_) return false;
  const int a = plan_.number[at(row)], b = plan_.number[at(column)];
  const int low = std::min(a, b), high = std::max(a, b), n = plan_.block;
  const auto front = std::upper_bound(plan_.fronts.begin(), plan_.fronts.end(), low,
                                      [](int c, const Front& f) { return c < f.first; }) -
                     1;
  const Panel z = panel(static_cast<std::size_t>(front - plan_.fronts.begin()), inverse_);
  const double* from = z.l11 + (low - front->first) * n * z.ld11 + (high - front->first) * n;
  int ld = z.ld11;
  if (high >= front->first + front->columns) {
    const auto rows = plan_.rows_of(*front);
    const auto found = std::lower_bound(rows.begin(), rows.end(), high);
    if (found == rows.end() || *found != high) return false;
    ld = z.ld21;
    from = z.l21 + (low - front->first) * n * ld + (found - rows.begin()) * n;
  }
  // The stored block has its rows in `high`.
  for (int c = 0; c < n; ++c)
    for (int r = 0; r < n; ++r) out[c * n + r] = a >= b ? from[c * ld + r] : from[r * ld + c];
  return true;
}

}  // namespace wayfare::cholesky
