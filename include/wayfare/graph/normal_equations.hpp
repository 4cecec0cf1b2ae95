#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include <wayfare/graph/block_sparse.hpp>
#include <wayfare/graph/pose_graph.hpp>

namespace wayfare {

/// H = Σ w JᵀΩJ and g = Σ w JᵀΩe of a pose graph over its free poses, with w the robust kernel's
/// weight. The layout is kept while the graph's structure (who is joined to whom, who is fixed)
/// stays what it was; each edge then knows the addresses of its blocks.
template <LieGroup G>
class NormalEquations {
 public:
  static constexpr int kDof = ManifoldTraits<G>::kDof;
  using Matrix = BlockSparse<kDof>;

  /// Lays out the pattern for `graph` (validated); returns whether it changed.
  bool set_structure(const PoseGraph<G>& graph) {
    if (same_structure(graph)) return false;
    fixed_ = graph.fixed;
    number_free_poses(graph);
    std::vector<std::pair<int, int>> pairs;
    ends_.clear();
    for (const auto& edge : graph.edges) {
      ends_.emplace_back(edge.from, edge.to);
      const int i = free_index(edge.from), j = free_index(edge.to);
      if (i >= 0 && j >= 0) pairs.emplace_back(i, j);
    }
    hessian_ = Matrix(static_cast<int>(free_.size()), pairs);
    gradient_.setZero(static_cast<Eigen::Index>(free_.size()) * kDof);
    find_addresses();
    return true;
  }

  /// The factor by which each edge counts besides the kernel; none given: one each.
  void set_weights(std::vector<double> weights) { weights_ = std::move(weights); }

  /// Fills H and g at the graph's poses; returns Σ w ρ(eᵀΩe).
  double linearise(const PoseGraph<G>& graph, const RobustKernel& kernel) {
    hessian_.set_zero();
    gradient_.setZero();
    squared_errors_.resize(graph.edges.size());
    double cost = 0.0;
    for (std::size_t k = 0; k < graph.edges.size(); ++k) {
      cost += add_edge(graph, k, kernel);
    }
    return cost;
  }

  /// Σ w ρ(eᵀΩe) alone.
  [[nodiscard]] double cost(const PoseGraph<G>& graph, const RobustKernel& kernel) const {
    double sum = 0.0;
    for (std::size_t k = 0; k < graph.edges.size(); ++k) {
      const PoseEdge<G>& edge = graph.edges[k];
      const double s = squared_error(graph, edge);
      sum += weight(k) * (edge.robust ? kernel(s).cost : s);
    }
    return sum;
  }

  /// eᵀΩe of every edge as it was last linearised.
  [[nodiscard]] const std::vector<double>& squared_errors() const { return squared_errors_; }

  [[nodiscard]] Matrix& hessian() { return hessian_; }
  [[nodiscard]] const Matrix& hessian() const { return hessian_; }
  [[nodiscard]] const Eigen::VectorXd& gradient() const { return gradient_; }

  /// The poses that are free, in the order of the block columns.
  [[nodiscard]] const std::vector<int>& free_poses() const { return free_; }
  /// The block column of a pose, −1 when it is fixed.
  [[nodiscard]] int free_index(int pose) const { return column_[static_cast<std::size_t>(pose)]; }

 private:
  using Square = SquareOf<G>;

  struct Slot {
    int from = -1, to = -1;  // block columns, −1 when fixed
    int from_diagonal = -1, to_diagonal = -1, coupling = -1;
  };

  bool same_structure(const PoseGraph<G>& graph) const {
    if (column_.size() != graph.poses.size() || ends_.size() != graph.edges.size()) return false;
    if (fixed_ != graph.fixed) return false;
    for (std::size_t k = 0; k < ends_.size(); ++k) {
      if (ends_[k] != std::pair(graph.edges[k].from, graph.edges[k].to)) return false;
    }
    return true;
  }

  void number_free_poses(const PoseGraph<G>& graph) {
    column_.assign(graph.poses.size(), 0);
    if (graph.fixed.empty()) column_[0] = -1;
    for (const int pose : graph.fixed) column_[static_cast<std::size_t>(pose)] = -1;
    free_.clear();
    for (int pose = 0; pose < graph.size(); ++pose) {
      int& column = column_[static_cast<std::size_t>(pose)];
      if (column < 0) continue;
      column = static_cast<int>(free_.size());
      free_.push_back(pose);
    }
  }

  void find_addresses() {
    slots_.clear();
    for (const auto& [from, to] : ends_) {
      Slot s;
      s.from = free_index(from);
      s.to = free_index(to);
      if (s.from >= 0) s.from_diagonal = hessian_.diagonal_index(s.from);
      if (s.to >= 0) s.to_diagonal = hessian_.diagonal_index(s.to);
      if (s.from >= 0 && s.to >= 0) {
        s.coupling = hessian_.find(std::min(s.from, s.to), std::max(s.from, s.to));
      }
      slots_.push_back(s);
    }
  }

  [[nodiscard]] double weight(std::size_t edge) const {
    return weights_.empty() ? 1.0 : weights_[edge];
  }

  double add_edge(const PoseGraph<G>& graph, std::size_t k, const RobustKernel& kernel) {
    const PoseEdge<G>& edge = graph.edges[k];
    const Slot& slot = slots_[k];
    const auto l =
        PoseError<G>::linearise(edge.measurement, graph.poses[static_cast<std::size_t>(edge.from)],
                                graph.poses[static_cast<std::size_t>(edge.to)]);
    TangentOf<G> we;
    we.noalias() = edge.information * l.error;
    const double s = l.error.dot(we);
    squared_errors_[k] = s;
    KernelValue rho = edge.robust ? kernel(s) : KernelValue{s, 1.0};
    rho.cost *= weight(k), rho.weight *= weight(k);
    we *= rho.weight;
    Square wa, wb;  // the weighted information times each Jacobian
    wa.noalias() = edge.information * l.by_from;
    wb.noalias() = edge.information * l.by_to;
    if (rho.weight != 1.0) wa *= rho.weight, wb *= rho.weight;
    if (slot.from >= 0) {
      hessian_.block(slot.from_diagonal).noalias() += l.by_from.transpose() * wa;
      gradient_.template segment<kDof>(slot.from * kDof).noalias() += l.by_from.transpose() * we;
    }
    if (slot.to >= 0) {
      hessian_.block(slot.to_diagonal).noalias() += l.by_to.transpose() * wb;
      gradient_.template segment<kDof>(slot.to * kDof).noalias() += l.by_to.transpose() * we;
    }
    if (slot.coupling < 0) return rho.cost;
    if (slot.from < slot.to) {
      hessian_.block(slot.coupling).noalias() += l.by_from.transpose() * wb;
    } else {
      hessian_.block(slot.coupling).noalias() += l.by_to.transpose() * wa;
    }
    return rho.cost;
  }

  std::vector<int> fixed_;
  std::vector<std::pair<int, int>> ends_;
  std::vector<int> column_;
  std::vector<int> free_;
  std::vector<Slot> slots_;
  std::vector<double> weights_, squared_errors_;
  Matrix hessian_;
  Eigen::VectorXd gradient_;
};

}  // namespace wayfare
