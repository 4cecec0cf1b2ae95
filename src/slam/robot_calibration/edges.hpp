#pragma once

#include <Eigen/Core>

#include <wayfare/core/se2.hpp>
#include <wayfare/graph/edge.hpp>
#include <wayfare/graph/edges.hpp>
#include <wayfare/graph/factor_graph.hpp>
#include <wayfare/graph/robust_kernel.hpp>

#include "slam/robot_calibration/base_motion.hpp"

namespace wayfare::calibration {

using Wheels = Eigen::Vector3d;             ///< scale left, scale right, base (m)
using Delay = Eigen::Matrix<double, 1, 1>;  ///< s
using GyroErrors = Eigen::Vector2d;         ///< scale, bias (rad/s)

/// Censi et al. 2013, (6): the laser's motion is that of the base, seen from its mounting.
struct LaserEdge {
  using Variables = EdgeVariables<Wheels, SE2d, Delay>;
  using Jacobians = AutomaticJacobians;
  static constexpr int kDim = 3;
  const BaseMotion* base = nullptr;
  double from_s = 0.0, to_s = 0.0;
  SE2d T_from_to;
  Eigen::Matrix3d information;

  template <class T>
  [[nodiscard]] Eigen::Matrix<T, 3, 1> error(const Eigen::Matrix<T, 3, 1>& wheels,
                                             const SE2<T>& T_base_laser,
                                             const Eigen::Matrix<T, 1, 1>& delay) const {
    const SE2<T> moved = base->between(T(T(from_s) - delay[0]), T(T(to_s) - delay[0]), wheels);
    return (T_from_to.inverse().cast<T>() * T_base_laser.inverse() * moved * T_base_laser).log();
  }
};

/// The radar's mean velocity over an interval, in its own axes: of its place on the base.
struct RadarEdge {
  using Variables = EdgeVariables<Wheels, SE2d, Delay>;
  using Jacobians = AutomaticJacobians;
  static constexpr int kDim = 2;
  const BaseMotion* base = nullptr;
  double from_s = 0.0, to_s = 0.0;
  Eigen::Vector2d velocity_m_s;
  Eigen::Matrix2d information;

  template <class T>
  [[nodiscard]] Eigen::Matrix<T, 2, 1> error(const Eigen::Matrix<T, 3, 1>& wheels,
                                             const SE2<T>& T_base_radar,
                                             const Eigen::Matrix<T, 1, 1>& delay) const {
    const SE2<T> moved = base->between(T(T(from_s) - delay[0]), T(T(to_s) - delay[0]), wheels);
    const Eigen::Matrix<T, 3, 1> twist = T(1.0 / (to_s - from_s)) * moved.log();
    const Eigen::Matrix<T, 2, 1>& lever = T_base_radar.translation();
    const Eigen::Matrix<T, 2, 1> at_radar(twist[0] - twist[2] * lever[1],
                                          twist[1] + twist[2] * lever[0]);
    return T_base_radar.rotation().inverse() * at_radar - velocity_m_s.cast<T>();
  }
};

/// The angle that a gyro reports over an interval of its own clock.
struct GyroEdge {
  using Variables = EdgeVariables<Wheels, GyroErrors, Delay>;
  using Jacobians = AutomaticJacobians;
  static constexpr int kDim = 1;
  const BaseMotion* base = nullptr;
  double from_s = 0.0, to_s = 0.0, turn_rad = 0.0;
  Eigen::Matrix<double, 1, 1> information;

  template <class T>
  [[nodiscard]] Eigen::Matrix<T, 1, 1> error(const Eigen::Matrix<T, 3, 1>& wheels,
                                             const Eigen::Matrix<T, 2, 1>& gyro,
                                             const Eigen::Matrix<T, 1, 1>& delay) const {
    const SE2<T> moved = base->between(T(T(from_s) - delay[0]), T(T(to_s) - delay[0]), wheels);
    return Eigen::Matrix<T, 1, 1>(gyro[0] * moved.rotation().angle().radians() +
                                  gyro[1] * T(to_s - from_s) - T(turn_rad));
  }
};

using Graph = FactorGraph<Variables<Wheels, SE2d, Delay, GyroErrors>,
                          Edges<Robust<LaserEdge>, Robust<RadarEdge>, Robust<GyroEdge>,
                                Prior<Wheels>, Prior<SE2d>, Prior<Delay>, Prior<GyroErrors>>>;

}  // namespace wayfare::calibration
