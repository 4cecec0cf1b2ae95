#pragma once

// Edges for factor graphs. Information matrices are of the errors as defined here; those of poses
// and landmarks are the errors of the g2o file format.

#include <cmath>

#include <Eigen/Core>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/graph/edge.hpp>
#include <wayfare/graph/pose_graph.hpp>

namespace wayfare {

/// A measured value of one variable: e = x ⊟ z, in the tangent space at z.
template <Manifold X>
struct Prior {
  using Variables = EdgeVariables<X>;                   ///< the one measured
  static constexpr int kDim = ManifoldTraits<X>::kDof;  ///< of the error

  X measurement;                                      ///< z
  SquareOf<X> information = SquareOf<X>::Identity();  ///< of the error

  /// e.
  [[nodiscard]] TangentOf<X> error(const X& x) const {
    return ManifoldTraits<X>::minus(x, measurement);
  }
  /// e, and its derivative Jr⁻¹(e) of Lie groups.
  [[nodiscard]] TangentOf<X> linearise(
      const X& x, EdgeJacobians<kDim, Variables>& j) const requires LieGroup<X> {
    const TangentOf<X> e = error(x);
    std::get<0>(j.by) = X::right_jacobian_inverse(e);
    return e;
  }
};

/// A measured pose of `to` in the frame of `from` (PoseError).
template <LieGroup G>
struct Between {
  using Variables = EdgeVariables<G, G>;                ///< the two poses
  static constexpr int kDim = ManifoldTraits<G>::kDof;  ///< of the error

  G measurement = G::identity();                      ///< Z, `to` in the frame of `from`
  SquareOf<G> information = SquareOf<G>::Identity();  ///< of the error

  /// PoseError of the measurement.
  [[nodiscard]] TangentOf<G> error(const G& from, const G& to) const {
    return PoseError<G>::error(measurement, from, to);
  }
  /// The error and its Jacobians by both poses.
  [[nodiscard]] TangentOf<G> linearise(const G& from, const G& to,
                                       EdgeJacobians<kDim, Variables>& j) const {
    const auto r = PoseError<G>::linearise(measurement, from, to);
    std::get<0>(j.by) = r.by_from;
    std::get<1>(j.by) = r.by_to;
    return r.error;
  }
};

/// The place of a landmark in the frame of a pose: e = X⁻¹ l − z, metres.
template <LieGroup G>
struct LandmarkPosition {
  static constexpr int kDim = G::kDof == 3 ? 2 : 3;  ///< of the error
  using Point = Eigen::Matrix<double, kDim, 1>;      ///< a place
  using Variables = EdgeVariables<G, Point>;         ///< pose, then landmark

  Point measurement = Point::Zero();  ///< z, m, in the axes of the pose
  /// Of the error.
  Eigen::Matrix<double, kDim, kDim> information = Eigen::Matrix<double, kDim, kDim>::Identity();

  /// e.
  [[nodiscard]] Point error(const G& pose, const Point& landmark) const {
    return pose.inverse() * landmark - measurement;
  }
  /// e and its Jacobians by pose and landmark.
  [[nodiscard]] Point linearise(const G& pose, const Point& landmark,
                                EdgeJacobians<kDim, Variables>& j) const {
    const Point seen = pose.inverse() * landmark;
    auto& [by_pose, by_landmark] = j.by;
    // X exp(δ) moves the landmark's image by −δt − δθ × image.
    by_pose.template leftCols<kDim>() = -Eigen::Matrix<double, kDim, kDim>::Identity();
    if constexpr (kDim == 2)
      by_pose.col(2) << seen.y(), -seen.x();
    else
      by_pose.template rightCols<3>() = skew(seen);
    by_landmark = pose.rotation().inverse().matrix();
    return seen - measurement;
  }
};

/// Bearing from the pose's x axis, counter-clockwise, rad, and distance of a landmark, m.
struct BearingRange {
  using Variables = EdgeVariables<SE2d, Eigen::Vector2d>;  ///< pose, then landmark
  static constexpr int kDim = 2;                           ///< of the error

  Angle bearing;                                              ///< measured
  double range_m = 0.0;                                       ///< measured
  Eigen::Matrix2d information = Eigen::Matrix2d::Identity();  ///< of (bearing, range)

  /// The error of the bearing is within (−π, π].
  [[nodiscard]] Eigen::Vector2d error(const SE2d& pose, const Eigen::Vector2d& landmark) const {
    const Eigen::Vector2d seen = pose.inverse() * landmark;
    return {wrap_to_pi(std::atan2(seen.y(), seen.x()) - bearing.radians()), seen.norm() - range_m};
  }
  /// The direction of a landmark at the pose itself is undefined: its Jacobian is zero there.
  [[nodiscard]] Eigen::Vector2d linearise(const SE2d& pose, const Eigen::Vector2d& landmark,
                                          EdgeJacobians<kDim, Variables>& j) const {
    const Eigen::Vector2d seen = pose.inverse() * landmark;
    const double r2 = seen.squaredNorm(), r = std::sqrt(r2);
    Eigen::Matrix2d by_seen = Eigen::Matrix2d::Zero();
    if (r > 0.0) by_seen << -seen.y() / r2, seen.x() / r2, seen.x() / r, seen.y() / r;
    auto& [by_pose, by_landmark] = j.by;
    by_pose << -by_seen, by_seen * Eigen::Vector2d(seen.y(), -seen.x());
    by_landmark = by_seen * pose.rotation().inverse().matrix();
    return error(pose, landmark);
  }
};

/// Distance between the origin of a pose and a point, m.
template <LieGroup G>
struct RangeTo {
  static constexpr int kDim = 1;                                 ///< of the error
  using Point = Eigen::Matrix<double, G::kDof == 3 ? 2 : 3, 1>;  ///< a place
  using Variables = EdgeVariables<G, Point>;                     ///< pose, then point

  double range_m = 0.0;  ///< measured
  /// Of the error.
  Eigen::Matrix<double, 1, 1> information = Eigen::Matrix<double, 1, 1>::Identity();

  /// Computed less measured distance, m.
  [[nodiscard]] Eigen::Matrix<double, 1, 1> error(const G& pose, const Point& point) const {
    return Eigen::Matrix<double, 1, 1>((point - pose.translation()).norm() - range_m);
  }
  /// The direction of a point at the pose itself is undefined: its Jacobian is zero there.
  [[nodiscard]] Eigen::Matrix<double, 1, 1> linearise(const G& pose, const Point& point,
                                                      EdgeJacobians<kDim, Variables>& j) const {
    const Point apart = point - pose.translation();
    const double range = apart.norm();
    const Point direction = range > 0.0 ? Point(apart / range) : Point::Zero();
    auto& [by_pose, by_point] = j.by;
    by_pose.setZero();
    by_pose.template leftCols<Point::RowsAtCompileTime>() =
        -direction.transpose() * pose.rotation().matrix();
    by_point = direction.transpose();
    return Eigen::Matrix<double, 1, 1>(range - range_m);
  }
};

/// A measured position of a pose, as of a GNSS antenna `lever_arm` from its origin, in its frame:
/// e = X·lever_arm − z, metres.
template <LieGroup G>
struct PositionOf {
  static constexpr int kDim = G::kDof == 3 ? 2 : 3;  ///< of the error
  using Point = Eigen::Matrix<double, kDim, 1>;      ///< a place
  using Variables = EdgeVariables<G>;                ///< the pose

  Point measurement = Point::Zero();  ///< z, m, in the frame of the poses
  /// Of the error.
  Eigen::Matrix<double, kDim, kDim> information = Eigen::Matrix<double, kDim, kDim>::Identity();
  Point lever_arm = Point::Zero();  ///< m, in the axes of the pose

  /// e.
  [[nodiscard]] Point error(const G& pose) const { return pose * lever_arm - measurement; }
  /// e and its Jacobian by the pose.
  [[nodiscard]] Point linearise(const G& pose, EdgeJacobians<kDim, Variables>& j) const {
    auto& [by_pose] = j.by;
    const Eigen::Matrix<double, kDim, kDim> r = pose.rotation().matrix();
    by_pose.template leftCols<kDim>() = r;
    if constexpr (kDim == 2)
      by_pose.col(2) = r * Point(-lever_arm.y(), lever_arm.x());
    else
      by_pose.template rightCols<3>() = -r * skew(lever_arm);
    return error(pose);
  }
};

/// A measured pose of a sensor at `T_body_sensor` on a body with pose X, in the frame of the poses:
/// e = t2v(Z⁻¹ X T), the priors of g2o.
template <LieGroup G>
struct PoseOf {
  static constexpr int kDim = ManifoldTraits<G>::kDof;  ///< of the error
  using Variables = EdgeVariables<G>;                   ///< the pose of the body

  G measurement = G::identity();                      ///< Z
  SquareOf<G> information = SquareOf<G>::Identity();  ///< of the error
  G T_body_sensor = G::identity();                    ///< mounting of the sensor

  /// e.
  [[nodiscard]] TangentOf<G> error(const G& pose) const {
    return PoseError<G>::error(measurement, G::identity(), pose * T_body_sensor);
  }
  /// e and its Jacobian by the pose.
  [[nodiscard]] TangentOf<G> linearise(const G& pose, EdgeJacobians<kDim, Variables>& j) const {
    const auto r = PoseError<G>::linearise(measurement, G::identity(), pose * T_body_sensor);
    // X exp(δ) T = X T exp(Ad(T⁻¹) δ)
    std::get<0>(j.by) = r.by_to * T_body_sensor.inverse().adjoint();
    return r.error;
  }
};

}  // namespace wayfare
