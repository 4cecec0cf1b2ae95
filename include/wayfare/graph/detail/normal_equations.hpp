#pragma once

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <utility>
#include <vector>

#include <wayfare/graph/detail/variable_columns.hpp>
#include <wayfare/graph/linear_solver.hpp>
#include <wayfare/graph/pose_graph.hpp>

namespace wayfare {

/// The contribution of one edge to H = Σ JᵀΩJ and g = Σ JᵀΩe.
template <LieGroup G>
struct EdgeTerms {
  SquareOf<G> from, to;  ///< on the diagonal, at X_i and X_j
  SquareOf<G> between;   ///< in row X_i and column X_j
  TangentOf<G> from_gradient, to_gradient;
  double squared_error = 0.0;  ///< eᵀΩe
};

void edge_terms(const PoseEdge<SE2d>& edge, const SE2d& from, const SE2d& to, EdgeTerms<SE2d>& out);
void edge_terms(const PoseEdge<SE3d>& edge, const SE3d& from, const SE3d& to, EdgeTerms<SE3d>& out);

/// H = Σ w JᵀΩJ and g = Σ w JᵀΩe of a pose graph over its free poses, with w the robust kernel's
/// weight. The pattern and each edge's block addresses are reused while the graph's structure
/// (edges and fixed poses) is unchanged.
template <LieGroup G>
class NormalEquations {
 public:
  static constexpr int kDof = ManifoldTraits<G>::kDof;
  using Matrix = BlockSparse<kDof>;

  /// Sets up the pattern for `graph` (validated); returns whether it changed.
  bool set_structure(const PoseGraph<G>& graph);

  /// Weights of the edges in addition to the kernel's; empty: 1.
  void set_weights(std::vector<double> weights) { weights_ = std::move(weights); }

  /// Fills H and g at the graph's poses; returns Σ w ρ(eᵀΩe).
  double linearise(const PoseGraph<G>& graph, const RobustKernel& kernel);

  /// Σ w ρ(eᵀΩe).
  [[nodiscard]] double cost(const PoseGraph<G>& graph, const RobustKernel& kernel) const;

  /// Σ eᵀΩe over all edges at the last linearisation, without kernel and weights.
  [[nodiscard]] double chi2() const {
    return std::accumulate(squared_errors_.begin(), squared_errors_.end(), 0.0);
  }

  [[nodiscard]] Matrix& hessian() { return hessian_; }
  [[nodiscard]] const Matrix& hessian() const { return hessian_; }
  [[nodiscard]] const Eigen::VectorXd& gradient() const { return gradient_; }

  /// The free poses in the order of the block columns.
  [[nodiscard]] const std::vector<int>& free() const { return columns_.free(); }
  /// The block column of a pose, −1 if it is fixed.
  [[nodiscard]] int column(int pose) const { return columns_.of(pose); }

 private:
  using Square = SquareOf<G>;

  struct Slot {
    int from = -1, to = -1;  // block columns, −1 when fixed
    int from_diagonal = -1, to_diagonal = -1, coupling = -1;
    bool first = false;  // of the edges with this coupling
  };

  [[nodiscard]] bool same_structure(const PoseGraph<G>& graph) const;

  void find_addresses();

  [[nodiscard]] double weight(std::size_t edge) const {
    return weights_.empty() ? 1.0 : weights_[edge];
  }

  double add_edge(const PoseGraph<G>& graph, std::size_t k, const RobustKernel& kernel);

  void couple(const Slot& slot, double w, const Square& between);

  std::vector<int> fixed_;
  std::vector<std::pair<int, int>> ends_;
  VariableColumns columns_;
  bool is_complete_ = false;  // an exception while the structure was made leaves a part of it
  std::vector<Slot> slots_;
  std::vector<double> weights_, squared_errors_;
  Matrix hessian_;
  Eigen::VectorXd gradient_;
};

template <LieGroup G>
bool NormalEquations<G>::set_structure(const PoseGraph<G>& graph) {
  if (is_complete_ && same_structure(graph)) return false;
  is_complete_ = false;
  fixed_ = graph.fixed;
  columns_.number(graph.size(), graph.held());
  std::vector<std::pair<int, int>> pairs;
  pairs.reserve(graph.edges.size());
  ends_.clear();
  ends_.reserve(graph.edges.size());
  for (const auto& edge : graph.edges) {
    ends_.emplace_back(edge.from, edge.to);
    const int i = column(edge.from), j = column(edge.to);
    if (i >= 0 && j >= 0) pairs.emplace_back(i, j);
  }
  hessian_ = Matrix(static_cast<int>(free().size()), pairs);
  gradient_.setZero(static_cast<Eigen::Index>(free().size()) * kDof);
  find_addresses();
  is_complete_ = true;
  return true;
}

template <LieGroup G>
double NormalEquations<G>::linearise(const PoseGraph<G>& graph, const RobustKernel& kernel) {
  for (int c = 0; c < hessian_.columns(); ++c) hessian_.block(hessian_.diagonal_index(c)).setZero();
  gradient_.setZero();
  squared_errors_.resize(graph.edges.size());
  double cost = 0.0;
  for (std::size_t k = 0; k < graph.edges.size(); ++k) {
    cost += add_edge(graph, k, kernel);
  }
  return cost;
}

template <LieGroup G>
double NormalEquations<G>::cost(const PoseGraph<G>& graph, const RobustKernel& kernel) const {
  double sum = 0.0;
  for (std::size_t k = 0; k < graph.edges.size(); ++k)
    sum += weight(k) * robust_cost(graph, graph.edges[k], kernel);
  return sum;
}

template <LieGroup G>
bool NormalEquations<G>::same_structure(const PoseGraph<G>& graph) const {
  if (columns_.size() != graph.size() || ends_.size() != graph.edges.size()) return false;
  if (fixed_ != graph.fixed) return false;
  for (std::size_t k = 0; k < ends_.size(); ++k) {
    if (ends_[k] != std::pair(graph.edges[k].from, graph.edges[k].to)) return false;
  }
  return true;
}

template <LieGroup G>
void NormalEquations<G>::find_addresses() {
  std::vector<char> coupled(static_cast<std::size_t>(hessian_.blocks()), 0);
  slots_.clear();
  slots_.reserve(ends_.size());
  for (const auto& [from, to] : ends_) {
    Slot s;
    s.from = column(from);
    s.to = column(to);
    if (s.from >= 0) s.from_diagonal = hessian_.diagonal_index(s.from);
    if (s.to >= 0) s.to_diagonal = hessian_.diagonal_index(s.to);
    if (s.from >= 0 && s.to >= 0) {
      s.coupling = hessian_.find(std::min(s.from, s.to), std::max(s.from, s.to));
      s.first = coupled[static_cast<std::size_t>(s.coupling)] == 0;
      coupled[static_cast<std::size_t>(s.coupling)] = 1;
    }
    slots_.push_back(s);
  }
}

template <LieGroup G>
double NormalEquations<G>::add_edge(const PoseGraph<G>& graph, std::size_t k,
                                    const RobustKernel& kernel) {
  const PoseEdge<G>& edge = graph.edges[k];
  const Slot& slot = slots_[k];
  EdgeTerms<G> terms;
  edge_terms(edge, graph.poses[static_cast<std::size_t>(edge.from)],
             graph.poses[static_cast<std::size_t>(edge.to)], terms);
  squared_errors_[k] = terms.squared_error;
  const KernelValue rho =
      edge.robust ? kernel(terms.squared_error) : KernelValue{terms.squared_error, 1.0};
  const double w = rho.weight * weight(k);
  if (slot.from >= 0) {
    hessian_.block(slot.from_diagonal) += w * terms.from;
    gradient_.template segment<kDof>(slot.from * kDof) += w * terms.from_gradient;
  }
  if (slot.to >= 0) {
    hessian_.block(slot.to_diagonal) += w * terms.to;
    gradient_.template segment<kDof>(slot.to * kDof) += w * terms.to_gradient;
  }
  if (slot.coupling >= 0) couple(slot, w, terms.between);
  return weight(k) * rho.cost;
}

/// The first edge of a coupling assigns the block, so it need not be cleared before.
template <LieGroup G>
void NormalEquations<G>::couple(const Slot& slot, double w, const Square& between) {
  auto block = hessian_.block(slot.coupling);
  const bool upright = slot.from < slot.to;
  if (slot.first && upright) {
    block = w * between;
  } else if (slot.first) {
    block = w * between.transpose();
  } else if (upright) {
    block += w * between;
  } else {
    block += w * between.transpose();
  }
}

// Compiled once in wayfare::graph.
extern template class NormalEquations<SE2d>;
extern template class NormalEquations<SE3d>;

}  // namespace wayfare
