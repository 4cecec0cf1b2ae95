#pragma once

// The error of a relative pose measurement as defined by the g2o file format, so that information
// matrices in files are interpreted correctly.
//
// Initial values of an optimisation, which decide the local minimum it reaches. Compiled in
// wayfare::graph for SE2d and SE3d.

#include <string>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/detail/eigen_alignment.hpp>
#include <wayfare/core/manifold.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/graph/robust_kernel.hpp>

namespace wayfare {

/// An error and its derivatives with respect to right perturbations of the two poses.
template <class T, int N>
struct ErrorAndJacobians {
  Eigen::Matrix<T, N, 1> error;    ///< e
  Eigen::Matrix<T, N, N> by_from;  ///< ∂e(X_i exp δ, X_j)/∂δ at 0
  Eigen::Matrix<T, N, N> by_to;    ///< ∂e(X_i, X_j exp δ)/∂δ at 0
};

/// e(Z, X_i, X_j) = t2v(Z⁻¹ X_i⁻¹ X_j): zero if X_i⁻¹ X_j equals the measurement Z. The translation
/// is that of the transformation, not of the group's logarithm.
template <class G>
struct PoseError;

/// (x, y, heading in (−π, π]); metres and radians.
template <class T>
struct PoseError<SE2<T>> {
  using Group = SE2<T>;                  ///< of the poses
  using Error = Eigen::Matrix<T, 3, 1>;  ///< (x, y, heading)

  /// e(Z, X_i, X_j).
  [[nodiscard]] static Error error(const Group& z, const Group& from, const Group& to) {
    return error_of(z.inverse() * (from.inverse() * to));
  }

  /// e and its Jacobians.
  [[nodiscard]] static ErrorAndJacobians<T, 3> linearise(const Group& z, const Group& from,
                                                         const Group& to) {
    const Group d = from.inverse() * to;
    const Group zi = z.inverse();
    const Group e = zi * d;
    const auto& rz = zi.rotation();
    const T c = rz.cos(), s = rz.sin();
    ErrorAndJacobians<T, 3> r;
    r.error = error_of(e);
    // A rotation of X_i by δθ moves X_i⁻¹X_j by −δθ (−d_y, d_x), in the measurement's frame.
    r.by_from << -c, s, c * d.y() + s * d.x(),  //
        -s, -c, s * d.y() - c * d.x(),          //
        T(0), T(0), T(-1);
    r.by_to << e.rotation().cos(), -e.rotation().sin(), T(0),  //
        e.rotation().sin(), e.rotation().cos(), T(0),          //
        T(0), T(0), T(1);
    return r;
  }

 private:
  static Error error_of(const Group& e) { return {e.x(), e.y(), e.heading().radians()}; }
};

/// (x, y, z, q_x, q_y, q_z) with q_w ≥ 0: metres, and the vector part of a unit quaternion, which
/// is half a small rotation vector.
template <class T>
struct PoseError<SE3<T>> {
  using Group = SE3<T>;                   ///< of the poses
  using Error = Eigen::Matrix<T, 6, 1>;   ///< translation, vector part
  using Block = Eigen::Matrix<T, 3, 3>;   ///< translation or rotation by one of them
  using Vector = Eigen::Matrix<T, 3, 1>;  ///< of three components

  /// e(Z, X_i, X_j).
  [[nodiscard]] static Error error(const Group& z, const Group& from, const Group& to) {
    const Group e = z.inverse() * (from.inverse() * to);
    const auto q = upper_half(e);
    Error r;
    r << e.translation(), q.vec();
    return r;
  }

  /// e and its Jacobians.
  [[nodiscard]] static ErrorAndJacobians<T, 6> linearise(const Group& z, const Group& from,
                                                         const Group& to) {
    const Group d = from.inverse() * to;
    const Group e = z.inverse() * d;
    const auto q = upper_half(e);
    const Vector v = q.vec();
    const Block rz = z.rotation().matrix().transpose();
    // q ⊗ (1, δθ/2): the vector part changes by ½ (w I + [v]×) δθ.
    const Block turn = T(0.5) * (q.w() * Block::Identity() + skew(v));
    ErrorAndJacobians<T, 6> r;
    r.error << e.translation(), v;
    r.by_to << e.rotation().matrix(), Block::Zero(), Block::Zero(), turn;
    // X_i exp δ has the effect on the error of X_j exp(−Ad(d⁻¹) δ).
    r.by_from << -rz, rz * skew(d.translation()), Block::Zero(),
        -turn * d.rotation().matrix().transpose();
    return r;
  }

 private:
  static Eigen::Quaternion<T> upper_half(const Group& e) {
    Eigen::Quaternion<T> q = e.rotation().quaternion();
    if (q.w() < T(0)) q.coeffs() = -q.coeffs();
    return q;
  }
};

/// A measurement of pose `to` in the frame of pose `from`, with information Ω (the inverse of the
/// covariance) of the error defined by PoseError.
template <LieGroup G>
struct PoseEdge {
  int from = 0;                                       ///< index of a pose
  int to = 0;                                         ///< index of another pose
  G measurement{};                                    ///< Z
  SquareOf<G> information = SquareOf<G>::Identity();  ///< Ω of the error
  /// Whether the robust kernel applies: true for possible outliers (loop closures), false for
  /// measurements that are only noisy (odometry).
  bool robust = false;
};

/// Poses and relative measurements between them. A plain value: poses and edges may be appended at
/// any time.
template <LieGroup G>
struct PoseGraph {
  static constexpr int kBlock = ManifoldTraits<G>::kDof;  ///< numbers of a step of one pose
  using Pose = G;                                         ///< of a variable
  using Values = std::vector<G>;                          ///< of all variables

  std::vector<G> poses;            ///< in one common frame; initial values of the next optimisation
  std::vector<PoseEdge<G>> edges;  ///< between these poses
  std::vector<int> fixed;          ///< fixed poses; empty: pose 0
  std::vector<std::string> labels;  ///< names of the poses in messages; empty: their indices

  /// Returns the new pose's index.
  int add_pose(const G& pose) {
    poses.push_back(pose);
    return size() - 1;
  }
  /// Number of poses.
  [[nodiscard]] int size() const { return static_cast<int>(poses.size()); }
  /// The fixed poses.
  [[nodiscard]] std::vector<int> held() const {
    return fixed.empty() && !poses.empty() ? std::vector<int>{0} : fixed;
  }
  /// Name of a pose in messages, without "pose".
  [[nodiscard]] std::string label(int pose) const {
    const auto i = static_cast<std::size_t>(pose);
    return pose >= 0 && i < labels.size() ? labels[i] : std::to_string(pose);
  }

  // What the optimisers use of any graph.
  /// Name of a pose in messages.
  [[nodiscard]] std::string name(int pose) const { return "pose " + label(pose); }
  /// Degrees of freedom of a pose.
  [[nodiscard]] int dof(int) const { return kBlock; }
  /// All poses.
  [[nodiscard]] const Values& values() const { return poses; }
  /// Replaces all poses.
  void set_values(const Values& values) { poses = values; }
  /// Moves a pose by `step`, a right perturbation.
  template <class Step>
  void move(int pose, const Step& step) {
    G& x = poses[static_cast<std::size_t>(pose)];
    x = ManifoldTraits<G>::plus(x, step);
  }
};

using PoseGraph2 = PoseGraph<SE2d>;  ///< in the plane
using PoseGraph3 = PoseGraph<SE3d>;  ///< in space

/// eᵀΩe of one edge at the graph's poses.
template <LieGroup G>
[[nodiscard]] double squared_error(const PoseGraph<G>& graph, const PoseEdge<G>& edge) {
  const auto e =
      PoseError<G>::error(edge.measurement, graph.poses[static_cast<std::size_t>(edge.from)],
                          graph.poses[static_cast<std::size_t>(edge.to)]);
  return not_negative(e.dot(edge.information * e));
}

/// ρ(eᵀΩe) of one edge; eᵀΩe if it is not `robust`.
template <LieGroup G>
[[nodiscard]] double robust_cost(const PoseGraph<G>& graph, const PoseEdge<G>& edge,
                                 const RobustKernel& kernel) {
  const double s = squared_error(graph, edge);
  return edge.robust ? kernel(s).cost : s;
}

/// Σ ρ(eᵀΩe): the optimiser's objective.
template <LieGroup G>
[[nodiscard]] double robust_cost(const PoseGraph<G>& graph, const RobustKernel& kernel) {
  double sum = 0.0;
  for (const auto& edge : graph.edges) sum += robust_cost(graph, edge, kernel);
  return sum;
}

/// Σ eᵀΩe over all edges, without a factor of ½ and without robust kernels.
template <LieGroup G>
[[nodiscard]] double chi2(const PoseGraph<G>& graph) {
  return robust_cost(graph, {});
}

/// Compiled once in wayfare::graph.
extern template double squared_error(const PoseGraph<SE2d>&, const PoseEdge<SE2d>&);
/// Compiled once in wayfare::graph.
extern template double squared_error(const PoseGraph<SE3d>&, const PoseEdge<SE3d>&);

/// Where the poses start before an optimisation.
enum class StartMethod {
  given,     ///< the graph's own poses
  odometry,  ///< the chain of edges between consecutive poses
  tree,      ///< along the spanning tree of least uncertainty
  chordal,   ///< chordal relaxation of the rotations, then translations
};

/// Which edges a spanning tree prefers.
enum class TreeEdges {
  any,            ///< the least uncertain path from a fixed pose, var x + var y + (2 m)² var θ
  trusted_first,  ///< the same, with as few `robust` edges as possible: those may be outliers
};

/// Initialises the free poses along the chain of edges between poses k and k + 1, from the fixed
/// poses (pose 0 if there are none); edges that are not `robust` are preferred. An Error names the
/// poses where the chain breaks, or the pose whose coordinates overflow. On an Error, here as
/// below, the poses are unchanged.
template <LieGroup G>
Result<void> start_from_odometry(PoseGraph<G>& graph);

/// Initialises the free poses along a spanning tree from the fixed poses. An Error if a pose is
/// connected to none of them, or its coordinates overflow.
template <LieGroup G>
Result<void> start_from_tree(PoseGraph<G>& graph, TreeEdges rather = TreeEdges::any);

/// Initialises the free poses, independently of their values: min Σ κ ‖R_j − R_i R_ij‖² over all
/// matrices R, each then replaced by the nearest rotation (Martinec and Pajdla 2007; Carlone et al.
/// 2015, "Initialization techniques for 3D SLAM", section III-B), then the translations that
/// minimise Σ eᵀΩe given those rotations; both linear. κ is the mean rotational information of an
/// edge. Close to the global optimum in the absence of outliers. An Error if the edges leave a
/// rotation or translation undetermined.
template <LieGroup G>
Result<void> start_from_chordal(PoseGraph<G>& graph);

/// By the function of that name; nothing for StartMethod::given.
template <LieGroup G>
Result<void> start_from(PoseGraph<G>& graph, StartMethod method) {
  switch (method) {
    case StartMethod::given:
      break;
    case StartMethod::odometry:
      return start_from_odometry(graph);
    case StartMethod::tree:
      return start_from_tree(graph);
    case StartMethod::chordal:
      return start_from_chordal(graph);
  }
  return {};
}

}  // namespace wayfare
