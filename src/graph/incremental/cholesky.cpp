// Numeric part: assembly and elimination of fronts, and back-substitution down the tree.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include <wayfare/graph/detail/incremental_cholesky.hpp>
#include <wayfare/graph/linear_solver.hpp>

#include "graph/cholesky/rank.hpp"
#include "graph/incremental/front.hpp"

namespace wayfare {

using detail::CliqueFront;

template <int N>
double IncrementalCholesky<N>::flops(const Clique& clique) {
  // A column with r rows below costs r² multiplications and additions.
  double sum = 0.0;
  auto below = static_cast<double>(N * clique.rows.size());
  for (int i = 0; i < N * clique.frontals; ++i, --below) sum += below * below;
  return sum;
}

template <int N>
FactorOutcome IncrementalCholesky<N>::factorise_fresh() {
  for (const int c : fresh_) {
    Clique& clique = cliques_[index(c)];
    assemble(clique);
    const int failed = eliminate(clique);
    if (failed >= 0) {
      const FactorOutcome whole = judge();
      return whole.ok ? FactorOutcome{false, clique.rows[index(failed / N)]} : whole;
    }
    last_flops_ += flops(clique);
  }
  const bool doubtful = std::any_of(fresh_.begin(), fresh_.end(), [&](int c) {
    return cliques_[index(c)].weak && nearly_undetermined(c);
  });
  return doubtful ? judge() : FactorOutcome{};
}

/// Assembles the clique's front from the terms and the updates of its children.
template <int N>
void IncrementalCholesky<N>::assemble(Clique& clique) {
  clique.numbers.assign(
      CliqueFront<N>::size(clique.frontals, clique.separators()) + N * N * index(clique.frontals),
      0.0);
  number_slots(clique);
  for (const int v : clique.eliminated()) add_terms(clique, v);
}

template <int N>
void IncrementalCholesky<N>::number_slots(const Clique& clique) {
  for (std::size_t i = 0; i < clique.rows.size(); ++i)
    slot_[index(clique.rows[i])] = static_cast<int>(i);
}

/// Adds all terms of `variable` on the diagonal, and those with variables eliminated later off it.
template <int N>
void IncrementalCholesky<N>::add_terms(Clique& clique, int variable) {
  const CliqueFront<N> front(clique.numbers.data(), clique.frontals, clique.separators());
  const int here = slot_[index(variable)];
  std::ptrdiff_t stride;
  double* const diagonal = front.at(here, here, stride);
  const std::ptrdiff_t diagonal_stride = stride;
  Eigen::Map<Vector> right(front.right(here));
  for (const int t : terms_of_[index(variable)]) {
    const auto [a, b] = ends_[index(t)];
    const Term& term = terms_[index(t)];
    const bool first = a == variable;
    detail::add_triangle<N>(diagonal, diagonal_stride, first ? term.aa.data() : term.bb.data(), N);
    right += first ? term.ra : term.rb;
    const int other = first ? b : a;
    // Variables that are not affected are eliminated before.
    if (other < 0 || variable_mark_[index(other)] != stamp_ ||
        place_[index(other)] < place_[index(variable)])
      continue;
    double* const to = front.at(slot_[index(other)], here, stride);
    if (first)
      detail::add_transposed<N>(to, stride, term.ab.data(), N);
    else
      detail::add_rows<N>(to, stride, term.ab.data(), N, N);
  }
  double* const information = information_of(clique, here);
  for (int j = 0; j < N; ++j)
    for (int i = j; i < N; ++i)
      information[i + N * j] = information[j + N * i] = diagonal[i + diagonal_stride * j];
  fill_unused(variable, diagonal, diagonal_stride + 1);
}

/// A_vv.
template <int N>
double* IncrementalCholesky<N>::information_of(Clique& clique, int frontal) {
  const std::size_t first = CliqueFront<N>::size(clique.frontals, clique.separators());
  return clique.numbers.data() + first + index(N * N) * index(frontal);
}

/// The rows that a variable does not use get the scale of its information: their step is zero. The
/// diagonal's numbers are `stride` apart.
template <int N>
void IncrementalCholesky<N>::fill_unused(int variable, double* diagonal,
                                         std::ptrdiff_t stride) const {
  const int dof = dof_[index(variable)];
  if (dof == N) return;
  double scale = 0.0;
  for (int i = 0; i < dof; ++i) scale = std::max(scale, diagonal[i * stride]);
  for (int i = dof; i < N; ++i) diagonal[i * stride] = scale > 0.0 ? scale : 1.0;
}

/// The slots of the separators: frontals, frontals + 1, …
template <int N>
const int* IncrementalCholesky<N>::later_slots(const Clique& clique) {
  while (ascending_.size() < clique.rows.size())
    ascending_.push_back(static_cast<int>(ascending_.size()));
  return ascending_.data() + clique.frontals;
}

/// Returns the first scalar column that is not positive definite, or −1.
template <int N>
int IncrementalCholesky<N>::eliminate(Clique& clique) {
  const cholesky::FrontKernels& kernels = cholesky::best_kernels(N);
  const CliqueFront<N> front(clique.numbers.data(), clique.frontals, clique.separators());
  const auto add_children = [&](bool eliminated) {
    for (const int c : clique.children) {
      Clique& child = cliques_[index(c)];
      const CliqueFront<N> from(child.numbers.data(), child.frontals, child.separators());
      slots_.clear();
      for (const int v : child.separator()) slots_.push_back(slot_[index(v)]);
      detail::extend_add<N>(front, from, slots_.data(), eliminated);
      if (!eliminated) continue;
      for (std::size_t i = 0; i < slots_.size(); ++i)
        Eigen::Map<Vector>(front.right(slots_[i])) +=
            Eigen::Map<const Vector>(from.right(child.frontals + static_cast<int>(i)));
    }
  };
  find_scales(clique);
  add_children(true);
  const int failed = kernels.factorise(front.panel());
  if (failed >= 0) return failed;
  clique.weak = suspicious(clique);
  kernels.update(front.panel(), front.update(), front.panel().ld21);
  add_children(false);
  scratch_.resize(index(front.panel().ld11 + front.panel().ld21));
  kernels.forward(front.panel(), 0, later_slots(clique), front.right(), scratch_.data());
  return -1;
}

template <int N>
const std::vector<int>& IncrementalCholesky<N>::solve(double threshold, ChangeUnit unit) {
  // Changes that were too small then may not be now.
  const bool whole = unit != held_unit_ || !(threshold >= held_back_);
  held_back_ = threshold;
  held_unit_ = unit;
  ++stamp_;
  changed_.clear();
  last_solved_ = 0;
  stack_.clear();
  for (int c = 0; whole && c < static_cast<int>(cliques_.size()); ++c)
    if (cliques_[index(c)].frontals > 0 && cliques_[index(c)].parent < 0) stack_.push_back(c);
  for (const int c : roots_)
    if (!whole && cliques_[index(c)].fresh && cliques_[index(c)].parent < 0) stack_.push_back(c);
  roots_.clear();
  while (!stack_.empty()) {
    Clique& clique = cliques_[index(stack_.back())];
    stack_.pop_back();
    clique.fresh = false;
    substitute(clique, threshold, unit);
    for (const int child : clique.children)
      if (whole || cliques_[index(child)].fresh || separator_changed(cliques_[index(child)]))
        stack_.push_back(child);
  }
  return changed_;
}

template <int N>
bool IncrementalCholesky<N>::separator_changed(const Clique& clique) const {
  const auto separator = clique.separator();
  return std::any_of(separator.begin(), separator.end(),
                     [&](int row) { return changed_mark_[index(row)] == stamp_; });
}

/// Lᵀ x = y for the frontals, given the separator's x.
template <int N>
void IncrementalCholesky<N>::substitute(Clique& clique, double threshold, ChangeUnit unit) {
  const CliqueFront<N> front(clique.numbers.data(), clique.frontals, clique.separators());
  gathered_.resize(N * clique.rows.size());
  double* const found = gathered_.data();
  std::copy_n(front.right(), N * clique.frontals, found);
  for (std::size_t i = index(clique.frontals); i < clique.rows.size(); ++i)
    Eigen::Map<Vector>(found + N * i) = x(clique.rows[i]);
  scratch_.resize(index(front.panel().ld11 + front.panel().ld21));
  cholesky::best_kernels(N).backward(front.panel(), 0, later_slots(clique), found, scratch_.data());
  const auto is_large = [&](int i, const Vector& change) {
    if (unit == ChangeUnit::component) return change.cwiseAbs().maxCoeff() > threshold;
    const Eigen::Map<const typename Term::Block> a(information_of(clique, i));
    return change.dot(a * change) > threshold * threshold;
  };
  for (int i = 0; i < clique.frontals; ++i) {
    const int v = clique.rows[index(i)];
    Eigen::Map<Vector> x(x_.data() + offset(v));
    const Eigen::Map<const Vector> now(found + offset(i));
    if (!is_large(i, now - x)) continue;
    x = now;
    changed_.push_back(v);
    changed_mark_[index(v)] = stamp_;
  }
  last_solved_ += clique.frontals;
}

/// D of the frontals, while their diagonal is that before elimination.
template <int N>
void IncrementalCholesky<N>::find_scales(Clique& clique) {
  const CliqueFront<N> front(clique.numbers.data(), clique.frontals, clique.separators());
  const cholesky::Panel& panel = front.panel();
  scales_.resize(index(panel.pivots));
  const std::ptrdiff_t stride = panel.ld11 + 1;
  for (int i = 0; i < clique.frontals; ++i)
    diagonal_scales<N>(panel.l11 + stride * N * i, stride, kLeadingUnits<N>,
                       scales_.data() + offset(i));
}

/// Whether some pivot of those just eliminated lost many digits.
template <int N>
bool IncrementalCholesky<N>::suspicious(Clique& clique) const {
  const CliqueFront<N> front(clique.numbers.data(), clique.frontals, clique.separators());
  const cholesky::Panel& panel = front.panel();
  double most = 0.0;
  for (int k = 0; k < panel.pivots; ++k) {
    const double inverse = panel.l11[static_cast<std::ptrdiff_t>(k) * (panel.ld11 + 1)];
    most = std::max(most, scales_[index(k)] * inverse * inverse);
  }
  return most > suspicious_loss(variables());
}

/// Whether a pivot of a clique may be only rounding. Probes are stored with their clique, so that
/// their cost is proportional to that of the factorisation.
template <int N>
bool IncrementalCholesky<N>::nearly_undetermined(int root) {
  stack_.assign(1, root);
  while (!stack_.empty()) {
    const int c = stack_.back();
    const std::size_t waiting = stack_.size();
    for (const int child : cliques_[index(c)].children)
      if (cliques_[index(child)].probes.empty()) stack_.push_back(child);
    if (stack_.size() > waiting) continue;
    find_probes(cliques_[index(c)]);
    stack_.pop_back();
  }
  const Clique& clique = cliques_[index(root)];
  const std::size_t stride = N * clique.rows.size();
  for (int k = 0; k < cholesky::kProbes; ++k)
    for (int i = 0; i < N * clique.frontals; ++i) {
      const double y = clique.probes[index(k) * stride + index(i)];
      if (y * y >= cholesky::kSlack / cholesky::kRounding) return true;
    }
  return false;
}

/// L⁻¹ D^½ z of the frontals, then the update of the separator.
template <int N>
void IncrementalCholesky<N>::find_probes(Clique& clique) {
  const CliqueFront<N> front(clique.numbers.data(), clique.frontals, clique.separators());
  const std::size_t stride = N * clique.rows.size();
  clique.probes.assign(cholesky::kProbes * stride, 0.0);
  number_slots(clique);
  scratch_.resize(index(front.panel().ld11 + front.panel().ld21));
  for (int k = 0; k < cholesky::kProbes; ++k) {
    double* const y = clique.probes.data() + index(k) * stride;
    for (int i = 0; i < clique.frontals; ++i) {
      const int variable = clique.rows[index(i)];
      const Vector d = scales_of(variable);
      for (int j = 0; j < N; ++j)
        y[N * i + j] = std::sqrt(d[j]) * cholesky::probe(offset(variable) + index(j), k);
    }
    for (const int c : clique.children) {
      const Clique& child = cliques_[index(c)];
      const double* const from = child.probes.data() + index(k) * N * child.rows.size();
      for (std::size_t i = index(child.frontals); i < child.rows.size(); ++i)
        Eigen::Map<Vector>(y + N * slot_[index(child.rows[i])]) +=
            Eigen::Map<const Vector>(from + N * i);
    }
    cholesky::best_kernels(N).forward(front.panel(), 0, later_slots(clique), y, scratch_.data());
  }
}

template <int N>
auto IncrementalCholesky<N>::scales_of(int variable) const -> Vector {
  Vector diagonal = Vector::Zero(), d;
  for (const int t : terms_of_[index(variable)]) {
    const Term& term = terms_[index(t)];
    diagonal += (ends_[index(t)].first == variable ? term.aa : term.bb).diagonal();
  }
  fill_unused(variable, diagonal.data(), 1);
  diagonal_scales<N>(diagonal.data(), 1, kLeadingUnits<N>, d.data());
  return d;
}

/// From the whole system in the batch solver's order, so that both decide alike. Costs a complete
/// factorisation: only for doubtful pivots.
template <int N>
FactorOutcome IncrementalCholesky<N>::judge() const {
  std::vector<std::pair<int, int>> pairs;
  for (const auto& [a, b] : ends_)
    if (a >= 0 && b >= 0) pairs.emplace_back(a, b);
  BlockSparse<N> h(variables(), pairs);
  for (std::size_t t = 0; t < ends_.size(); ++t) {
    const auto [a, b] = ends_[t];
    const Term& term = terms_[t];
    if (a >= 0) h.block(h.diagonal_index(a)) += term.aa;
    if (b >= 0) h.block(h.diagonal_index(b)) += term.bb;
    if (a < 0 || b < 0) continue;
    auto block = h.block(h.find(std::min(a, b), std::max(a, b)));
    if (a < b) {
      block += term.ab;
    } else {
      block += term.ab.transpose();
    }
  }
  for (int v = 0; v < variables(); ++v) fill_unused(v, h.data(h.diagonal_index(v)), N + 1);
  MultifrontalCholesky<N> whole;
  whole.analyse(h);
  return whole.factorise(h);
}

template class IncrementalCholesky<2>;
template class IncrementalCholesky<3>;
template class IncrementalCholesky<6>;

}  // namespace wayfare
