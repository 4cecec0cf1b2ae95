#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/SVD>

#include <wayfare/graph/multifrontal_cholesky.hpp>
#include <wayfare/graph/pose_columns.hpp>
#include <wayfare/graph/start.hpp>
#include <wayfare/graph/validate.hpp>

namespace wayfare {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

SO2d nearest_rotation(const Eigen::Matrix2d& m) {
  // The nearest multiple of a rotation is the mean of what each column says.
  const double c = m(0, 0) + m(1, 1), s = m(1, 0) - m(0, 1), size = std::hypot(c, s);
  return size > 0.0 ? SO2d::from_unit_complex(c / size, s / size) : SO2d();
}

SO3d nearest_rotation(const Eigen::Matrix3d& m) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d &u = svd.matrixU(), &v = svd.matrixV();
  const Eigen::Vector3d signs(1.0, 1.0, u.determinant() * v.determinant() < 0.0 ? -1.0 : 1.0);
  return SO3d(Eigen::Matrix3d(u * signs.asDiagonal() * v.transpose()));
}

/// Linear least squares over one N-vector a pose whose terms join two poses:
/// H_ii += D, H_jj += D, H_ij −= C, b_j += v, b_i −= v.
template <LieGroup G>
class PairwiseSystem {
 public:
  static constexpr int N = static_cast<int>(G::Vector::RowsAtCompileTime);
  using Block = Eigen::Matrix<double, N, N>;
  using Vector = Eigen::Matrix<double, N, 1>;

  explicit PairwiseSystem(const PoseGraph<G>& graph) {
    columns_.number(graph);
    std::vector<std::pair<int, int>> pairs;
    for (const auto& e : graph.edges)
      if (column(e.from) >= 0 && column(e.to) >= 0)
        pairs.emplace_back(column(e.from), column(e.to));
    matrix_ = BlockSparse<N>(size(), pairs);
    for (const auto& e : graph.edges) {
      const int i = column(e.from), j = column(e.to);
      coupling_.push_back(i >= 0 && j >= 0 ? matrix_.find(std::min(i, j), std::max(i, j)) : -1);
    }
    solver_.analyse(matrix_);
  }

  [[nodiscard]] const std::vector<int>& free() const { return columns_.free(); }
  [[nodiscard]] int column(int pose) const { return columns_.of(pose); }

  void clear() { matrix_.set_zero(); }
  void add(std::size_t edge, int from, int to, const Block& d, const Block& c) {
    const int i = column(from), j = column(to);
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
  /// −1 where it came out, else the pose that is not determined; the first free one where the
  /// solver cannot tell.
  int factorise() {
    const FactorOutcome outcome = solver_.factorise(matrix_);
    return outcome.ok ? -1 : free()[at(std::max(outcome.block, 0))];
  }
  Eigen::VectorXd zeros() const { return Eigen::VectorXd::Zero(N * size()); }
  void add_to(Eigen::VectorXd& b, int pose, const Vector& v) const {
    if (column(pose) >= 0) b.template segment<N>(N * column(pose)) += v;
  }
  void solve(Eigen::VectorXd& b) { solver_.solve_in_place(b); }

 private:
  [[nodiscard]] int size() const { return static_cast<int>(free().size()); }

  PoseColumns columns_;
  BlockSparse<N> matrix_;
  std::vector<int> coupling_;  // of each edge, −1 where an end is fixed
  MultifrontalCholesky<N> solver_;
};

template <LieGroup G>
class ChordalStart {
 public:
  static constexpr int N = PairwiseSystem<G>::N;
  static constexpr int kTurns = ManifoldTraits<G>::kDof - N;
  using Block = typename PairwiseSystem<G>::Block;
  using Vector = typename PairwiseSystem<G>::Vector;

  explicit ChordalStart(const PoseGraph<G>& graph) : graph_(graph), system_(graph) {}

  /// κ: the mean information about rotation.
  static double rotation_weight(const PoseEdge<G>& edge) {
    return edge.information.template bottomRightCorner<kTurns, kTurns>().trace() / kTurns;
  }

  Result<void> relax_rotations(std::vector<G>& x);
  Result<void> solve_translations(std::vector<G>& x);

 private:
  Error undetermined(int pose, const char* what) const {
    return {ErrorCode::degenerate, std::string("the ") + what + " of pose " + graph_.label(pose) +
                                       " is not determined by the edges"};
  }

  const PoseGraph<G>& graph_;
  PairwiseSystem<G> system_;
};

/// Row a of R is an N-vector r with r_j = Zᵀ r_i across every edge, so the rows are N right-hand
/// sides of one matrix.
template <LieGroup G>
Result<void> ChordalStart<G>::relax_rotations(std::vector<G>& x) {
  system_.clear();
  for (std::size_t k = 0; k < graph_.edges.size(); ++k) {
    const PoseEdge<G>& e = graph_.edges[k];
    const double weight = rotation_weight(e);
    system_.add(k, e.from, e.to, weight * Block::Identity(),
                weight * e.measurement.rotation().matrix());
  }
  if (const int pose = system_.factorise(); pose >= 0) return undetermined(pose, "rotation");
  Eigen::Matrix<double, Eigen::Dynamic, N> rows(system_.zeros().size(), N);
  for (int row = 0; row < N; ++row) {
    Eigen::VectorXd b = system_.zeros();
    for (const PoseEdge<G>& e : graph_.edges) {
      const bool from_fixed = system_.column(e.from) < 0;
      if (from_fixed == (system_.column(e.to) < 0)) continue;
      const Block turn = rotation_weight(e) * e.measurement.rotation().matrix();
      const Vector held =
          x[at(from_fixed ? e.from : e.to)].rotation().matrix().row(row).transpose();
      if (from_fixed) {
        system_.add_to(b, e.to, turn.transpose() * held);
      } else {
        system_.add_to(b, e.from, turn * held);
      }
    }
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

/// With the rotations held, the error's translation is Aᵀ(t_j − t_i − R_i t_z) with A = R_i R_z:
/// linear in the translations.
template <LieGroup G>
Result<void> ChordalStart<G>::solve_translations(std::vector<G>& x) {
  system_.clear();
  Eigen::VectorXd b = system_.zeros();
  for (std::size_t k = 0; k < graph_.edges.size(); ++k) {
    const PoseEdge<G>& e = graph_.edges[k];
    const G &from = x[at(e.from)], &to = x[at(e.to)];
    const Block a = (from.rotation() * e.measurement.rotation()).matrix();
    const Block w = a * e.information.template topLeftCorner<N, N>() * a.transpose();
    const TangentOf<G> error = PoseError<G>::error(e.measurement, from, to);
    const Vector v =
        w * (from.rotation() * e.measurement.translation()) -
        a * (e.information.template topRightCorner<N, kTurns>() * error.template tail<kTurns>());
    system_.add(k, e.from, e.to, w, w);
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

}  // namespace

template <LieGroup G>
Result<void> start_from_chordal(PoseGraph<G>& graph) {
  if (auto valid = validate(graph); !valid) return valid;
  const auto turns = [](const PoseEdge<G>& e) { return ChordalStart<G>::rotation_weight(e) > 0.0; };
  const auto moves = [](const PoseEdge<G>& e) {
    return e.information.diagonal().template head<ChordalStart<G>::N>().sum() > 0.0;
  };
  auto joined = validate_connection(graph, turns, " by edges that measure rotation");
  if (joined) joined = validate_connection(graph, moves, " by edges that measure translation");
  if (!joined) return joined;
  ChordalStart<G> start(graph);
  std::vector<G> x = graph.poses;
  if (auto done = start.relax_rotations(x); !done) return done;
  if (auto done = start.solve_translations(x); !done) return done;
  graph.poses = std::move(x);
  return {};
}

template Result<void> start_from_chordal(PoseGraph<SE2d>&);
template Result<void> start_from_chordal(PoseGraph<SE3d>&);

}  // namespace wayfare
