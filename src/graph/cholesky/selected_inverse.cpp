#include <algorithm>

#include "graph/cholesky/factor.hpp"

namespace wayfare::cholesky {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

}  // namespace

// Each front's Z₂₂ uses the memory of its update: its lifetime, from the parent to the front, is
// that of the update in reverse.
void Factor::invert() {
  inverse_.reserve(factor_size_);
  scratch_.reserve(inverse_scratch_);
  for (std::size_t s = places_.size(); s-- > 0;) {
    const Front& f = plan_.fronts[s];
    const Panel z = panel(s, inverse_);
    const double* const z22 = stack_.data() + places_[s].update;
    kernels_.invert(panel(s, values_), z, z22, scratch_.data());
    for (int k = f.children_begin; k < f.children_end; ++k) {
      const int child = plan_.children[at(k)];
      kernels_.gather_inverse(update_of(child), z, z22, stack_.data() + places_[at(child)].update);
    }
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
