#pragma once

// FactorOutcome's rule for linear solvers of one's own.

#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include <wayfare/graph/linear_solver.hpp>

namespace wayfare {

/// Decides by FactorOutcome's rule whether a solver's matrix was singular. A pivot that is large
/// beside D needs no closer look, which clears most matrices at once; where a pivot is small, was
/// not given, or the solver failed, MultifrontalCholesky decides, at the cost of its factorisation.
///
///   FactorOutcome factorise(const BlockSparse<3>& h) {
///     check_.start(h);
///     …                         // check_.pivot(j, d_jj) for each j; without pivots: for none
///     return check_.outcome(h, solved);
///   }
template <int N>
class RankCheck {
 public:
  RankCheck() = default;
  /// `leading` as of MultifrontalCholesky.
  explicit RankCheck(int leading) : leading_(leading) {}

  /// The next matrix has another pattern.
  void analyse() { judge_.reset(); }

  /// A factorisation of `h` starts.
  void start(const BlockSparse<N>& h) {
    loss_ = suspicious_loss(h.columns());
    cleared_ = 0;
    scale_.resize(static_cast<std::size_t>(h.columns()) * N);
    for (int c = 0; c < h.columns(); ++c)
      diagonal_scales<N>(h.data(h.diagonal_index(c)), N + 1, leading_,
                         scale_.data() + static_cast<std::size_t>(c) * N);
  }

  /// The pivot of row j of H, in H's own order: d_jj of H = L D Lᵀ, l_jj² of H = L Lᵀ. Once for
  /// each j.
  void pivot(int j, double information) {
    const double most = loss_ * information;
    if (scale_[static_cast<std::size_t>(j)] <= most && std::isfinite(most)) ++cleared_;
  }

  /// Of the same `h`; `solved` is whether the solver can solve with its factorisation.
  FactorOutcome outcome(const BlockSparse<N>& h, bool solved = true) {
    if (solved && cleared_ == scale_.size()) return {};
    if (!judge_) judge_.emplace(leading_).analyse(h);
    FactorOutcome outcome = judge_->factorise(h);
    outcome.ok = outcome.ok && solved;
    return outcome;
  }

 private:
  int leading_ = kLeadingUnits<N>;
  double loss_ = 0.0;
  std::size_t cleared_ = 0;                       // pivots that are not small
  std::vector<double> scale_;                     // D
  std::optional<MultifrontalCholesky<N>> judge_;  // once it is asked
};

}  // namespace wayfare
