// Whether a system that grows has a solution at all: the rule of cholesky/rank.hpp.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include <wayfare/graph/detail/incremental_cholesky.hpp>
#include <wayfare/graph/multifrontal_cholesky.hpp>

#include "front.hpp"
#include "graph/cholesky/rank.hpp"

namespace wayfare {

using detail::CliqueFront;

/// D of the frontals, while their diagonal is that before elimination.
template <int N>
void IncrementalCholesky<N>::find_scales(Clique& clique) {
  const CliqueFront<N> front(clique.numbers.data(), clique.frontals, clique.separators());
  const cholesky::Panel& panel = front.panel();
  scales_.resize(index(panel.pivots));
  for (int i = 0; i < clique.frontals; ++i)
    cholesky::scales<N>(panel.l11 + N * i * (panel.ld11 + 1), panel.ld11 + 1, kLeadingUnits<N>,
                        scales_.data() + N * i);
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

/// Whether a pivot of a clique may be nothing but rounding. Probes are kept with their clique, so
/// that they cost in proportion to what is factorised.
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

/// L⁻¹ D^½ z: of the frontals, then what is handed on to the separator.
template <int N>
void IncrementalCholesky<N>::find_probes(Clique& clique) {
  const CliqueFront<N> front(clique.numbers.data(), clique.frontals, clique.separators());
  const std::size_t stride = N * clique.rows.size();
  clique.probes.assign(cholesky::kProbes * stride, 0.0);
  for (std::size_t i = 0; i < clique.rows.size(); ++i)
    slot_[index(clique.rows[i])] = static_cast<int>(i);
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
  cholesky::scales<N>(diagonal.data(), 1, kLeadingUnits<N>, d.data());
  return d;
}

/// By the whole system in the batch solver's order, so that both decide alike. Costs a whole
/// factorisation: only where what is kept here leaves a doubt.
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
  MultifrontalCholesky<N> whole;
  whole.analyse(h);
  return whole.factorise(h);
}

template class IncrementalCholesky<3>;
template class IncrementalCholesky<6>;

}  // namespace wayfare
