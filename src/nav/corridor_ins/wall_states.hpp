#pragma once

// The walls in the filter's state: predicted measurements, and augmentation by new walls.

#include <cmath>
#include <numbers>

#include <Eigen/Core>

#include <wayfare/core/se2.hpp>
#include <wayfare/filter/ekf.hpp>
#include <wayfare/match/lines.hpp>
#include <wayfare/nav/detail/corridor_motion.hpp>

namespace wayfare::corridor {

using namespace corridor_state;

using Filter = Ekf<CorridorVector>;
using Row = Eigen::Matrix<double, 1, kSize>;
using Rows = Eigen::Matrix<double, Eigen::Dynamic, kSize>;

/// Predicted wall measurements and their Jacobians.
struct Predicted {
  CorridorWalls walls;
  Eigen::Matrix<double, 3, kSize> rows;      ///< of direction, left, right
  Eigen::Matrix<double, 2, kSize> end_rows;  ///< of α and ρ of the wall across
};

/// The covariance of (α, ρ).
[[nodiscard]] inline Eigen::Matrix2d angle_first(const NormalPoint& wall) {
  const Eigen::Matrix2d& c = wall.covariance;  // of (ρ, α)
  return (Eigen::Matrix2d() << c(1, 1), c(0, 1), c(0, 1), c(0, 0)).finished();
}

/// Walls in the state and the reference points of their offsets, which are nearby so that angle and
/// offset errors of far corridors are not fully correlated.
class WallStates {
 public:
  explicit WallStates(const SE2d& T_base_laser) : T_base_laser_(T_base_laser) {}

  [[nodiscard]] bool has_walls() const { return left_ || right_; }
  void forget_walls() { left_ = right_ = false; }
  void forget_end() { end_ = false; }

  [[nodiscard]] SE2d laser_pose(const CorridorVector& x) const {
    return SE2d(x[kX], x[kY], Angle::radians(x[kHeading])) * T_base_laser_;
  }

  [[nodiscard]] Predicted predict(const Filter& filter) const {
    const CorridorVector& x = filter.state();
    const double laser_heading = x[kHeading] + T_base_laser_.heading().radians();
    Predicted p;
    p.rows.setZero();
    p.end_rows.setZero();
    p.walls.direction = Angle::radians(x[kDirection] - laser_heading).wrapped();
    p.rows(0, kDirection) = 1.0;
    p.rows(0, kHeading) = -1.0;
    const Eigen::Vector2d u = unit(x[kDirection]), n = quarter_turn(u);
    const Eigen::Vector2d offset = laser_pose(x).translation() - reference_m_;
    const Row by_position = position_row(n, x);
    for (const int side : {1, 2}) {
      const int entry = side == 1 ? kLeft : kRight;
      p.rows.row(side) = -by_position;
      p.rows(side, kDirection) = u.dot(offset);
      p.rows(side, entry) = 1.0;
      auto& wall = side == 1 ? p.walls.left : p.walls.right;
      if (side == 1 ? left_ : right_) wall = Wall{x[entry] - n.dot(offset)};
    }
    p.walls.covariance = p.rows * filter.covariance() * p.rows.transpose();
    if (!end_) return p;
    const Eigen::Vector2d m = unit(x[kEndAlpha]);
    const Eigen::Vector2d end_offset = laser_pose(x).translation() - end_reference_m_;
    p.end_rows(0, kEndAlpha) = 1.0;
    p.end_rows(0, kHeading) = -1.0;
    p.end_rows.row(1) = -position_row(m, x);
    p.end_rows(1, kEndAlpha) = -quarter_turn(m).dot(end_offset);
    p.end_rows(1, kEndOffset) = 1.0;
    p.walls.end = NormalPoint{x[kEndOffset] - m.dot(end_offset),
                              Angle::radians(x[kEndAlpha] - laser_heading).wrapped(),
                              Eigen::Matrix2d::Zero()};
    return p;
  }

  /// Augments the state with `detected` walls: all of them, or the missing side.
  void enter(const CorridorWalls& detected, Filter& filter) {
    const CorridorVector& x = filter.state();
    reference_m_ = laser_pose(x).translation();
    const double direction =
        x[kHeading] + T_base_laser_.heading().radians() + detected.direction.radians();
    left_ = detected.left.has_value();
    right_ = detected.right.has_value();
    const Row by_position = position_row(quarter_turn(unit(direction)), x);
    Rows rows = Rows::Zero(3, kSize);
    rows(0, kHeading) = 1.0;
    rows.row(1) = by_position;
    rows.row(2) = by_position;
    Eigen::Matrix3d noise = detected.covariance;
    // An entry without a wall is independent of the others, with a nominal variance.
    if (!left_) rows.row(1).setZero(), noise(1, 1) = 1.0;
    if (!right_) rows.row(2).setZero(), noise(2, 2) = 1.0;
    replace(rows, noise, Eigen::Vector3i(kDirection, kLeft, kRight),
            Eigen::Vector3d(direction, left_ ? detected.left->offset_m : 0.0,
                            right_ ? detected.right->offset_m : 0.0),
            filter);
  }

  void enter_missing_side(const CorridorWalls& detected, Filter& filter) {
    const CorridorVector& x = filter.state();
    const bool is_left = !left_ && detected.left, is_right = !right_ && detected.right;
    if (is_left == is_right) return;
    const Eigen::Vector2d u = unit(x[kDirection]), n = quarter_turn(u);
    const Eigen::Vector2d offset = laser_pose(x).translation() - reference_m_;
    Rows row = Rows::Zero(1, kSize);
    row.row(0) = position_row(n, x);
    row(0, kDirection) = -u.dot(offset);
    const double measured_m = is_left ? detected.left->offset_m : detected.right->offset_m;
    const Eigen::Index k = is_left ? 1 : 2;
    // The offset's error is correlated with the direction of the same scan, already used: twice its
    // variance covers that.
    replace(row, Eigen::MatrixXd::Constant(1, 1, 2.0 * detected.covariance(k, k)),
            Eigen::VectorXi::Constant(1, is_left ? kLeft : kRight),
            Eigen::VectorXd::Constant(1, measured_m + n.dot(offset)), filter);
    (is_left ? left_ : right_) = true;
  }

  void enter_end(const NormalPoint& detected, Filter& filter) {
    const CorridorVector& x = filter.state();
    end_reference_m_ = laser_pose(x).translation();
    const double alpha = x[kHeading] + T_base_laser_.heading().radians() + detected.alpha.radians();
    Rows rows = Rows::Zero(2, kSize);
    rows(0, kHeading) = 1.0;
    rows.row(1) = position_row(unit(alpha), x);
    replace(rows, angle_first(detected), Eigen::Vector2i(kEndAlpha, kEndOffset),
            Eigen::Vector2d(alpha, detected.rho_m), filter);
    end_ = true;
  }

 private:
  static Eigen::Vector2d unit(double angle_rad) {
    return {std::cos(angle_rad), std::sin(angle_rad)};
  }
  static Eigen::Vector2d quarter_turn(const Eigen::Vector2d& v) { return {-v.y(), v.x()}; }

  /// ∂(n · p)/∂state for the laser at p and constant n.
  [[nodiscard]] Row position_row(const Eigen::Vector2d& n, const CorridorVector& x) const {
    const SO2d turn(Angle::radians(x[kHeading]));
    Row row = Row::Zero();
    row[kX] = n.x();
    row[kY] = n.y();
    row[kHeading] = n.dot(quarter_turn(turn * T_base_laser_.translation()));
    return row;
  }

  /// x' = (x, y(x) + noise): replaces entries of the state by functions of the rest and a
  /// measurement.
  static void replace(const Rows& by_state, const Eigen::MatrixXd& noise,
                      const Eigen::VectorXi& entries, const Eigen::VectorXd& values,
                      Filter& filter) {
    CorridorMatrix a = CorridorMatrix::Identity(), q = CorridorMatrix::Zero();
    CorridorVector x = filter.state();
    for (Eigen::Index i = 0; i < entries.size(); ++i) {
      a.row(entries[i]) = by_state.row(i);
      x[entries[i]] = values[i];
      for (Eigen::Index j = 0; j < entries.size(); ++j) q(entries[i], entries[j]) = noise(i, j);
    }
    const CorridorMatrix p = a * filter.covariance() * a.transpose() + q;
    filter.set_state(x);
    filter.set_covariance(0.5 * (p + p.transpose()));
  }

  SE2d T_base_laser_;
  Eigen::Vector2d reference_m_ = Eigen::Vector2d::Zero(),
                  end_reference_m_ = Eigen::Vector2d::Zero();
  bool left_ = false, right_ = false, end_ = false;
};

/// `detected` with direction and sides reversed if opposite to `predicted`.
[[nodiscard]] inline CorridorWalls facing(const CorridorWalls& detected, Angle predicted) {
  const bool against =
      std::abs(wrap_to_pi((detected.direction - predicted).radians())) > 0.5 * std::numbers::pi;
  return against ? reversed(detected) : detected;
}

}  // namespace wayfare::corridor
