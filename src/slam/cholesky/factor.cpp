#include "cholesky/factor.hpp"

#include <algorithm>
#include <utility>

namespace wayfare::cholesky {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

}  // namespace

Factor::Factor(FrontPlan plan) : plan_(std::move(plan)), kernels_(best_kernels(plan_.block)) {
  place_fronts();
  place_updates();
  permuted_.resize(plan_.order.size() * at(plan_.block));
}

void Factor::place_fronts() {
  places_.resize(plan_.fronts.size());
  for (std::size_t s = 0; s < places_.size(); ++s) {
    const Front& f = plan_.fronts[s];
    Place& place = places_[s];
    const int p = f.columns * plan_.block, m = f.rows * plan_.block;
    // What is factorised in one go needs no room for tiles that reach past it.
    place.ld11 = p == plan_.block || p == 6 ? p : padded(p);
    place.ld21 = padded(m);
    place.l11 = factor_size_;
    place.l21 = factor_size_ + at(padded(place.ld11 * p));
    factor_size_ = place.l21 + at(place.ld21) * at(p);
    inverse_scratch_ = std::max(inverse_scratch_, at(padded(p)) * at(2 * p + m));
    most_scratch_ = std::max(most_scratch_, place.ld11 + place.ld21);
  }
}

void Factor::place_updates() {
  std::vector<int> depth(places_.size(), 0);
  for (std::size_t s = places_.size(); s-- > 0;)
    if (const int p = plan_.fronts[s].parent; p >= 0) depth[s] = depth[at(p)] + 1;
  std::size_t top[2] = {0, 0}, highest[2] = {0, 0};
  for (std::size_t s = 0; s < places_.size(); ++s) {
    const Front& f = plan_.fronts[s];
    std::size_t& own = top[depth[s] % 2];
    std::size_t& children = top[1 - depth[s] % 2];
    for (int k = f.children_begin; k < f.children_end; ++k)
      children = std::min(children, places_[at(plan_.children[at(k)])].update);
    places_[s].update = own;
    own += at(places_[s].ld21) * at(f.rows * plan_.block);
    highest[depth[s] % 2] = std::max(highest[depth[s] % 2], own);
  }
  for (std::size_t s = 0; s < places_.size(); ++s)
    if (depth[s] % 2 == 1) places_[s].update += highest[0];
  stack_size_ = highest[0] + highest[1];
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
  for (int k = f.children_begin; k < f.children_end; ++k)
    kernels_.add_to_panel(update_of(plan_.children[at(k)]), front);
  if (const int failed = kernels_.factorise(front); failed >= 0)
    return plan_.order[at(f.first + failed / plan_.block)];
  if (f.rows == 0) return -1;
  double* const update = stack_.data() + places_[s].update;
  kernels_.update(front, update, front.ld21);
  for (int k = f.children_begin; k < f.children_end; ++k)
    kernels_.add_to_update(update_of(plan_.children[at(k)]), update, front.ld21);
  return -1;
}

int Factor::factorise(const double* h) {
  values_.reserve(factor_size_);
  stack_.reserve(stack_size_);
  scratch_.reserve(at(most_scratch_));
  inverted_ = false;
  for (std::size_t s = 0; s < places_.size(); ++s)
    if (const int failed = factorise_front(s, h); failed >= 0) return failed;
  return -1;
}

void Factor::solve_in_place(double* x) {
  double* const y = permuted_.data();
  const int columns = static_cast<int>(plan_.order.size());
  kernels_.gather(plan_.order.data(), columns, x, y);
  const auto substitute = [&](std::size_t s, auto kernel) {
    const Front& f = plan_.fronts[s];
    kernel(panel(s, values_), f.first, plan_.rows.data() + f.rows_begin, y, scratch_.data());
  };
  for (std::size_t s = 0; s < places_.size(); ++s) substitute(s, kernels_.forward);
  for (std::size_t s = places_.size(); s-- > 0;) substitute(s, kernels_.backward);
  kernels_.gather(plan_.number.data(), columns, y, x);
}

}  // namespace wayfare::cholesky
