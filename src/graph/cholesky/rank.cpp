// The rank of H from its factorisation.

#include "graph/cholesky/rank.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "graph/cholesky/factor.hpp"

namespace wayfare::cholesky {

void Factor::place_diagonal() {
  diagonal_.resize(plan_.order.size());
  scale_.resize(plan_.order.size() * at(plan_.block));
  for (const Front& f : plan_.fronts) {
    for (int k = f.placements_begin; k < f.placements_end; ++k) {
      const Placement& p = plan_.placements[at(k)];
      blocks_ = std::max(blocks_, at(p.block) + 1);
      if (!p.below && p.row == p.column) diagonal_[at(f.first + p.column)] = p.block;
    }
  }
}

namespace {

/// The largest D_jj / l_jj² of a front.
template <int N>
double largest_loss(const Panel& front, const int* diagonal, const double* h, int leading) {
  const double* inverse = front.l11;
  double most = 0.0;
  for (int c = 0; c < front.pivots / N; ++c) {
    double d[N];
    diagonal_scales<N>(h + static_cast<long>(diagonal[c]) * (N * N), N + 1, leading, d);
    for (int i = 0; i < N; ++i, inverse += front.ld11 + 1)
      most = std::max(most, d[i] * *inverse * *inverse);
  }
  return most;
}

/// The same code for each size of a block.
template <class Op>
auto with_block(int block, const Op& op) {
  if (block == 2) return op(std::integral_constant<int, 2>());
  return block == 3 ? op(std::integral_constant<int, 3>()) : op(std::integral_constant<int, 6>());
}

}  // namespace

bool Factor::loses_digits(std::size_t s, const double* h, const Panel& front) {
  const int first = plan_.fronts[s].first;
  const double loss = with_block(plan_.block, [&](auto n) {
    return largest_loss<n()>(front, diagonal_.data() + first, h, leading_);
  });
  return loss > suspicious_loss(static_cast<int>(diagonal_.size()));
}

/// Raises `most`, by the new numbering, to the estimates of (L⁻¹ D L⁻ᵀ)_jj by probe `k`. Returns
/// the largest.
double Factor::estimate_shares(int k, std::vector<double>& most) {
  std::vector<double> y(most.size() + kPad);
  for (std::size_t i = 0; i < most.size(); ++i) y[i] = std::sqrt(scale_[i]) * probe(i, k);
  for (std::size_t s = 0; s < places_.size(); ++s) substitute(s, kernels_.forward, y.data());
  double largest = 0.0;
  for (std::size_t i = 0; i < most.size(); ++i)
    largest = std::max(largest, most[i] = std::max(most[i], y[i] * y[i]));
  return largest;
}

/// v = L⁻ᵀ e_j, without the factor that makes it one at j.
std::vector<double> Factor::response(std::size_t j) {
  std::vector<double> v(scale_.size() + kPad, 0.0);
  v[j] = 1.0;
  for (std::size_t s = places_.size(); s-- > 0;)
    if (at(plan_.fronts[s].first * plan_.block) <= j) substitute(s, kernels_.backward, v.data());
  return v;
}

/// (L⁻¹ D L⁻ᵀ)_jj, given v of column j.
double Factor::share(const std::vector<double>& v) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < scale_.size(); ++i) sum += scale_[i] * v[i] * v[i];
  return sum;
}

/// The first direction in the order of elimination that is undetermined.
FactorOutcome Factor::find_undetermined() {
  std::vector<double> estimates(scale_.size(), 0.0);
  double largest = 0.0;
  for (int k = 0; k < kFirstProbes; ++k) largest = std::max(largest, estimate_shares(k, estimates));
  if (largest < kDoubt / kRounding) return {};
  for (int k = kFirstProbes; k < kProbes; ++k) estimate_shares(k, estimates);
  int borderline = 16;  // largest number of directions computed for doubtful estimates
  for (std::size_t j = 0; j < scale_.size(); ++j) {
    if (!(estimates[j] >= kSlack / kRounding)) continue;
    if (estimates[j] < 10.0 / kRounding && borderline-- <= 0) continue;
    const std::vector<double> v = response(j);
    if (!(share(v) >= 1.0 / kRounding)) continue;
    const std::size_t n = at(plan_.block), column = j / n;
    FactorOutcome outcome{false, plan_.order[column]};
    double length = 0.0;
    for (std::size_t i = 0; i < n; ++i) length = std::hypot(length, v[column * n + i]);
    for (std::size_t i = 0; i < n; ++i) outcome.direction[i] = v[column * n + i] / length;
    return outcome;
  }
  return {true, -1, {}, true};
}

/// The rank of H, given the result of eliminate(h).
FactorOutcome Factor::judge(const double* h, int failed) {
  if (failed < 0 && !suspicious_) return {};
  const int n = plan_.block;
  with_block(n, [&](auto size) {
    for (std::size_t c = 0; c < diagonal_.size(); ++c)
      diagonal_scales<size()>(h + at(diagonal_[c]) * at(n * n), n + 1, leading_,
                              scale_.data() + c * at(n));
  });
  if (failed < 0) return find_undetermined();
  // A matrix that is singular to rounding becomes positive definite if more than rounding is added
  // to its diagonal; its undetermined directions then have that information only.
  std::vector<double> lifted(h, h + blocks_ * at(n * n));
  for (std::size_t c = 0; c < diagonal_.size(); ++c)
    for (int i = 0; i < n; ++i)
      lifted[at(diagonal_[c]) * at(n * n) + at(i * (n + 1))] += kLift * scale_[c * at(n) + at(i)];
  FactorOutcome outcome{false, failed};
  if (eliminate(lifted.data()) >= 0) return outcome;
  if (const FactorOutcome found = find_undetermined(); !found.ok) outcome = found;
  return outcome;
}

}  // namespace wayfare::cholesky
