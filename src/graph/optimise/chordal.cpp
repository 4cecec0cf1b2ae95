#include "graph/optimise/chordal.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include <Eigen/SVD>

#include <wayfare/graph/detail/validate.hpp>
#include <wayfare/graph/pose_graph.hpp>

#include "graph/lists.hpp"

namespace wayfare {
namespace {

using detail::at;

SO2d nearest_rotation(const Eigen::Matrix2d& m) {
  const double c = m(0, 0) + m(1, 1), s = m(1, 0) - m(0, 1), size = std::hypot(c, s);
  return size > 0.0 ? SO2d::from_unit_complex(c / size, s / size) : SO2d();
}

SO3d nearest_rotation(const Eigen::Matrix3d& m) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d &u = svd.matrixU(), &v = svd.matrixV();
  const Eigen::Vector3d signs(1.0, 1.0, u.determinant() * v.determinant() < 0.0 ? -1.0 : 1.0);
  return SO3d(Eigen::Matrix3d(u * signs.asDiagonal() * v.transpose()));
}

}  // namespace

template <LieGroup G>
PairwiseSystem<G>::PairwiseSystem(const PoseGraph<G>& graph) {
  columns_.number(graph.size(), graph.held());
  std::vector<std::pair<int, int>> pairs;
  for (const auto& e : graph.edges)
    if (column(e.from) >= 0 && column(e.to) >= 0) pairs.emplace_back(column(e.from), column(e.to));
  matrix_ = BlockSparse<N>(static_cast<int>(free().size()), pairs);
  coupling_.reserve(graph.edges.size());
  for (const auto& e : graph.edges) {
    const int i = column(e.from), j = column(e.to);
    coupling_.push_back(i >= 0 && j >= 0 ? matrix_.find(std::min(i, j), std::max(i, j)) : -1);
  }
  if (!free().empty()) solver_.analyse(matrix_);
}

template <LieGroup G>
void PairwiseSystem<G>::add(std::size_t edge, const PoseEdge<G>& ends, const Block& d,
                            const Block& c) {
  const int i = column(ends.from), j = column(ends.to);
  if (i >= 0) matrix_.block(matrix_.diagonal_index(i)) += d;
  if (j >= 0) matrix_.block(matrix_.diagonal_index(j)) += d;
  if (coupling_[edge] < 0) return;
  auto block = matrix_.block(coupling_[edge]);
  if (i < j) {
    block -= c;
  } else {
    block -= c.transpose();
  }
}

template <LieGroup G>
int PairwiseSystem<G>::factorise() {
  const FactorOutcome outcome = solver_.factorise(matrix_);
  return outcome.ok ? -1 : free()[at(std::max(outcome.block, 0))];
}

/// κ: the mean rotational information.
template <LieGroup G>
double ChordalSolver<G>::rotation_weight(const PoseEdge<G>& edge) {
  return edge.information.diagonal().template tail<kTurns>().mean();
}

template <LieGroup G>
Result<void> ChordalSolver<G>::check(const PoseGraph<G>& graph) {
  const auto turns = [](const PoseEdge<G>& e) { return rotation_weight(e) > 0.0; };
  const auto moves = [](const PoseEdge<G>& e) {
    return e.information.diagonal().template head<N>().sum() > 0.0;
  };
  auto joined = validate_connection(graph, turns, " by edges that measure rotation");
  if (joined) joined = validate_connection(graph, moves, " by edges that measure translation");
  return joined;
}

template <LieGroup G>
Error ChordalSolver<G>::undetermined(int pose, const char* what) const {
  return {ErrorCode::degenerate, std::string("the ") + what + " of pose " + graph_.label(pose) +
                                     " is not determined by the edges"};
}

template <LieGroup G>
Result<void> ChordalSolver<G>::solve(std::vector<G>& x, const std::vector<double>& weights) {
  if (system_.free().empty()) return {};
  weights_ = &weights;
  auto done = relax_rotations(x);
  return done ? solve_translations(x) : done;
}

/// Row a of R is an N-vector r with r_j = Zᵀ r_i across every edge, so the rows are N right-hand
/// sides of one matrix.
template <LieGroup G>
Result<void> ChordalSolver<G>::relax_rotations(std::vector<G>& x) {
  system_.clear();
  for (std::size_t k = 0; k < graph_.edges.size(); ++k) {
    const PoseEdge<G>& e = graph_.edges[k];
    const double kappa = weight(k) * rotation_weight(e);
    system_.add(k, e, kappa * Block::Identity(), kappa * e.measurement.rotation().matrix());
  }
  if (const int pose = system_.factorise(); pose >= 0) return undetermined(pose, "rotation");
  Eigen::Matrix<double, Eigen::Dynamic, N> rows(system_.zeros().size(), N);
  for (int row = 0; row < N; ++row) {
    Eigen::VectorXd b = pull_of_fixed(x, row);
    system_.solve(b);
    rows.col(row) = b;
  }
  for (const int pose : system_.free()) {
    const Block r = rows.template middleRows<N>(N * system_.column(pose)).transpose();
    if (!r.allFinite()) return undetermined(pose, "rotation");
    x[at(pose)] = G(x[at(pose)].translation(), nearest_rotation(r));
  }
  return {};
}

/// The right-hand side for one row of the rotations.
template <LieGroup G>
Eigen::VectorXd ChordalSolver<G>::pull_of_fixed(const std::vector<G>& x, int row) const {
  Eigen::VectorXd b = system_.zeros();
  for (std::size_t k = 0; k < graph_.edges.size(); ++k) {
    const PoseEdge<G>& e = graph_.edges[k];
    const bool from_fixed = system_.column(e.from) < 0;
    if (from_fixed == (system_.column(e.to) < 0)) continue;
    const Block turn = weight(k) * rotation_weight(e) * e.measurement.rotation().matrix();
    const Block held = x[at(from_fixed ? e.from : e.to)].rotation().matrix();
    if (from_fixed) {
      system_.add_to(b, e.to, turn.transpose() * held.row(row).transpose());
    } else {
      system_.add_to(b, e.from, turn * held.row(row).transpose());
    }
  }
  return b;
}

/// With fixed rotations, the error's translation is Aᵀ(t_j − t_i − R_i t_z) with A = R_i R_z:
/// linear in the translations.
template <LieGroup G>
Result<void> ChordalSolver<G>::solve_translations(std::vector<G>& x) {
  system_.clear();
  Eigen::VectorXd b = system_.zeros();
  for (std::size_t k = 0; k < graph_.edges.size(); ++k) {
    const PoseEdge<G>& e = graph_.edges[k];
    const G &from = x[at(e.from)], &to = x[at(e.to)];
    const Block a = (from.rotation() * e.measurement.rotation()).matrix();
    const SquareOf<G> information = weight(k) * e.information;
    const Block w = a * information.template topLeftCorner<N, N>() * a.transpose();
    const TangentOf<G> error = PoseError<G>::error(e.measurement, from, to);
    const Vector v =
        w * (from.rotation() * e.measurement.translation()) -
        a * (information.template topRightCorner<N, kTurns>() * error.template tail<kTurns>());
    system_.add(k, e, w, w);
    system_.add_to(b, e.to, v);
    system_.add_to(b, e.from, -v);
    if (system_.column(e.from) < 0) system_.add_to(b, e.to, w * from.translation());
    if (system_.column(e.to) < 0) system_.add_to(b, e.from, w * to.translation());
  }
  if (const int pose = system_.factorise(); pose >= 0) return undetermined(pose, "translation");
  system_.solve(b);
  for (const int pose : system_.free()) {
    const Vector t = b.template segment<N>(N * system_.column(pose));
    if (!t.allFinite()) return undetermined(pose, "translation");
    x[at(pose)] = G(t, x[at(pose)].rotation());
  }
  return {};
}

template class PairwiseSystem<SE2d>;
template class PairwiseSystem<SE3d>;
template class ChordalSolver<SE2d>;
template class ChordalSolver<SE3d>;

template <LieGroup G>
Result<void> start_from_chordal(PoseGraph<G>& graph) {
  auto checked = validate(graph);
  if (checked) checked = ChordalSolver<G>::check(graph);
  if (!checked) return checked;
  std::vector<G> x = graph.poses;
  if (auto done = ChordalSolver<G>(graph).solve(x, {}); !done) return done;
  graph.poses = std::move(x);
  return {};
}

template Result<void> start_from_chordal(PoseGraph<SE2d>&);
template Result<void> start_from_chordal(PoseGraph<SE3d>&);

}  // namespace wayfare
