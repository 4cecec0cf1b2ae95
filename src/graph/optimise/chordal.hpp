#pragma once

// Rotation relaxation, then translations: both are linear least squares over one N-vector per pose
// with the same pattern, so one symbolic analysis serves solutions with different weights.

#include <cstddef>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/graph/detail/normal_equations.hpp>
#include <wayfare/graph/linear_solver.hpp>
#include <wayfare/graph/pose_graph.hpp>

namespace wayfare {

/// Least squares whose terms couple two poses: H_ii += D, H_jj += D, H_ij −= C.
template <LieGroup G>
class PairwiseSystem {
 public:
  static constexpr int N = static_cast<int>(G::Vector::RowsAtCompileTime);
  using Block = Eigen::Matrix<double, N, N>;
  using Vector = Eigen::Matrix<double, N, 1>;

  explicit PairwiseSystem(const PoseGraph<G>& graph);

  [[nodiscard]] const std::vector<int>& free() const { return columns_.free(); }
  [[nodiscard]] int column(int pose) const { return columns_.of(pose); }
  [[nodiscard]] Eigen::VectorXd zeros() const {
    return Eigen::VectorXd::Zero(static_cast<Eigen::Index>(free().size()) * N);
  }

  void clear() { matrix_.set_zero(); }
  void add(std::size_t edge, const PoseEdge<G>& ends, const Block& d, const Block& c);
  void add_to(Eigen::VectorXd& b, int pose, const Vector& v) const {
    if (column(pose) >= 0) b.template segment<N>(N * column(pose)) += v;
  }
  /// −1 on success, else a pose that is not determined.
  int factorise();
  void solve(Eigen::VectorXd& b) { solver_.solve_in_place(b); }

 private:
  VariableColumns columns_;
  BlockSparse<N> matrix_;
  std::vector<int> coupling_;          // of each edge, −1 where an end is fixed
  MultifrontalCholesky<N> solver_{N};  // one unit for all
};

template <LieGroup G>
class ChordalSolver {
 public:
  static constexpr int N = PairwiseSystem<G>::N;
  static constexpr int kTurns = ManifoldTraits<G>::kDof - N;

  /// `graph`, valid, must outlive it and keep its structure. `check` gives an Error if its edges
  /// cannot determine the rotations or the translations alone.
  explicit ChordalSolver(const PoseGraph<G>& graph) : graph_(graph), system_(graph) {}
  static Result<void> check(const PoseGraph<G>& graph);

  /// Writes the free poses to `x`; `weights` of the edges, empty: ones. On an Error `x` may be
  /// partially changed.
  Result<void> solve(std::vector<G>& x, const std::vector<double>& weights);

 private:
  using Block = typename PairwiseSystem<G>::Block;
  using Vector = typename PairwiseSystem<G>::Vector;

  static double rotation_weight(const PoseEdge<G>& edge);
  [[nodiscard]] double weight(std::size_t edge) const {
    return weights_->empty() ? 1.0 : (*weights_)[edge];
  }
  [[nodiscard]] Error undetermined(int pose, const char* what) const;
  Result<void> relax_rotations(std::vector<G>& x);
  [[nodiscard]] Eigen::VectorXd pull_of_fixed(const std::vector<G>& x, int row) const;
  Result<void> solve_translations(std::vector<G>& x);

  const PoseGraph<G>& graph_;
  PairwiseSystem<G> system_;
  const std::vector<double>* weights_ = nullptr;
};

}  // namespace wayfare
