#pragma once

// The walls in the filter's state: predicted measurements, and augmentation by new walls.

#include <cmath>
#include <concepts>
#include <initializer_list>
#include <numbers>

#include <Eigen/Core>

#include <wayfare/core/se2.hpp>
#include <wayfare/filter/ekf.hpp>
#include <wayfare/match/lines.hpp>
#include <wayfare/nav/detail/corridor_motion.hpp>

namespace wayfare::corridor {

using Filter = Ekf<CorridorState>;

/// The variances of a block's errors, in a covariance of the state.
template <class Block, class P>
[[nodiscard]] auto variances(P& covariance) {
  return covariance.diagonal().template segment<kBlockDof<Block>>(CorridorState::index<Block>());
}

/// A measurement: the line or lines of Walls (Sides or End) as the laser sees them, angles relative
/// to its x axis and offsets from itself.
template <class Walls>
struct SeenBy {
  using Blocks = BlockList<Position, Heading, Walls>;
  using Jacobians = AutomaticJacobians;
  static constexpr int kDim = kBlockDof<Walls>;
  /// Offsets are along the direction's left-hand normal, or the direction is that of the normal.
  static constexpr int kAlongNormal = std::same_as<Walls, Sides> ? 1 : 0;

  SE2d T_base_laser;
  /// Of the offsets; nearby, so that angle and offset errors of far corridors are not fully
  /// correlated.
  Eigen::Vector2d reference_m = Eigen::Vector2d::Zero();

  template <class T>
  [[nodiscard]] Eigen::Matrix<T, 2, 1> laser_m(const Eigen::Matrix<T, 2, 1>& position,
                                               const Eigen::Matrix<T, 1, 1>& heading) const {
    return position +
           SO2<T>(BasicAngle<T>::radians(heading[0])) * T_base_laser.translation().cast<T>();
  }

  template <class T>
  [[nodiscard]] Eigen::Matrix<T, kDim, 1> error(const Eigen::Matrix<T, 2, 1>& position,
                                                const Eigen::Matrix<T, 1, 1>& heading,
                                                Eigen::Matrix<T, kDim, 1> walls) const {
    const SO2<T> direction(BasicAngle<T>::radians(walls[0]));
    const Eigen::Matrix<T, 2, 1> offset =
        direction.inverse() *
        Eigen::Matrix<T, 2, 1>(laser_m(position, heading) - reference_m.cast<T>());
    walls[0] -= heading[0] + T(T_base_laser.heading().radians());
    for (int i = 1; i < kDim; ++i) walls[i] -= offset[kAlongNormal];
    return walls;
  }
};
using SeenSides = decltype(measure(SeenBy<Sides>{}, CorridorState{}));
using SeenEnd = decltype(measure(SeenBy<End>{}, CorridorState{}));

/// Predicted walls, and their measurements less what will be measured.
struct Predicted {
  CorridorWalls walls;
  SeenSides sides;  ///< direction, left, right
  SeenEnd end;      ///< α and ρ of the wall across
};

/// The covariance of (α, ρ).
[[nodiscard]] inline Eigen::Matrix2d angle_first(const NormalPoint& wall) {
  const Eigen::Matrix2d& c = wall.covariance;  // of (ρ, α)
  return (Eigen::Matrix2d() << c(1, 1), c(0, 1), c(0, 1), c(0, 0)).finished();
}

/// The walls that are known, and the reference points of their offsets.
class WallStates {
 public:
  explicit WallStates(const SE2d& T_base_laser) : sides_{T_base_laser}, end_{T_base_laser} {}

  [[nodiscard]] bool has_walls() const { return left_ || right_; }
  void forget_walls() { left_ = right_ = false; }
  void forget_end() { has_end_ = has_line_across_ = false; }
  [[nodiscard]] bool has_end() const { return has_end_; }
  [[nodiscard]] bool has_line_across() const { return has_line_across_; }

  [[nodiscard]] Predicted predict(const Filter& filter) const {
    const CorridorState& x = filter.state();
    Predicted p{{}, measure(sides_, x), measure(end_, x)};
    const Eigen::Vector3d sides = -p.sides.innovation;
    const auto& [index, h] = p.sides.rows;
    p.walls.direction = Angle::radians(sides[0]).wrapped();
    if (left_) p.walls.left = Wall{sides[1]};
    if (right_) p.walls.right = Wall{sides[2]};
    p.walls.covariance = h * filter.covariance()(index, index) * h.transpose();
    const Eigen::Vector2d end = -p.end.innovation;
    if (has_end_)
      p.walls.end = NormalPoint{end[1], Angle::radians(end[0]).wrapped(), Eigen::Matrix2d::Zero()};
    return p;
  }

  /// Augments the state with `detected` walls: all of them, or the missing side.
  void enter(const CorridorWalls& detected, Filter& filter) {
    CorridorState x = filter.state();
    left_ = detected.left.has_value();
    right_ = detected.right.has_value();
    x.get<Sides>() << refer(sides_, x) + detected.direction.radians(),
        left_ ? detected.left->offset_m : 0.0, right_ ? detected.right->offset_m : 0.0;
    SeenSides seen = measure(sides_, x);
    seen.covariance = detected.covariance;
    // An entry without a wall is independent of the others, with a nominal variance.
    for (const int side : {1, 2})
      if (side == 1 ? !left_ : !right_)
        seen.rows.value.row(side).setZero(), seen.covariance(side, side) = 1.0;
    replace<Sides>({0, 1, 2}, x, seen, filter);
  }

  void enter_missing_side(const CorridorWalls& detected, Filter& filter) {
    const bool is_left = !left_ && detected.left, is_right = !right_ && detected.right;
    if (is_left == is_right) return;
    const int side = is_left ? 1 : 2;
    CorridorState x = filter.state();
    SeenSides seen = measure(sides_, x);
    x.get<Sides>()[side] +=
        seen.innovation[side] + (is_left ? detected.left->offset_m : detected.right->offset_m);
    // The offset's error is correlated with the direction of the same scan, already used: twice its
    // variance covers that.
    seen.covariance = 2.0 * detected.covariance;
    replace<Sides>({side}, x, seen, filter);
    (is_left ? left_ : right_) = true;
  }

  void enter_end(const NormalPoint& detected, Filter& filter) {
    CorridorState x = filter.state();
    x.get<End>() << refer(end_, x) + detected.alpha.radians(), detected.rho_m;
    SeenEnd seen = measure(end_, x);
    seen.covariance = angle_first(detected);
    replace<End>({0, 1}, x, seen, filter);
    has_end_ = true;
    has_line_across_ = false;
  }

  /// In place of a wall across: the line through the laser across the corridor. Its offset is then
  /// the way back along the corridor.
  void enter_line_across(const CorridorWalls& detected, Filter& filter) {
    constexpr double kExact = 1e-8;
    NormalPoint line{0.0, detected.direction, kExact * Eigen::Matrix2d::Identity()};
    line.covariance(1, 1) += detected.covariance(0, 0);
    enter_end(line, filter);
    has_end_ = false;
    has_line_across_ = true;
  }

 private:
  /// Refers offsets to where the laser is. Returns the direction of its x axis, rad.
  template <class Walls>
  static double refer(SeenBy<Walls>& walls, const CorridorState& x) {
    walls.reference_m = walls.laser_m(x.get<Position>(), x.get<Heading>());
    return x.get<Heading>()[0] + walls.T_base_laser.heading().radians();
  }

  /// Some errors of Walls become those of a measurement of them, which has unit derivatives by
  /// them.
  template <class Walls, int n, class Rows>
  static void replace(std::initializer_list<int> which, const CorridorState& next,
                      const VectorMeasurement<double, n, Rows>& seen, Filter& filter) {
    struct Step {
      CorridorState state;
      Filter::Square phi = Filter::Square::Identity(), q = Filter::Square::Zero();
    } step{next};
    constexpr int kFirst = CorridorState::index<Walls>();
    for (const int i : which) {
      step.phi(kFirst + i, seen.rows.index) = -seen.rows.value.row(i);
      for (const int j : which) {
        step.phi(kFirst + i, kFirst + j) = 0.0;
        step.q(kFirst + i, kFirst + j) = seen.covariance(i, j);
      }
    }
    filter.predict([&](const CorridorState&) { return step; });
  }

  SeenBy<Sides> sides_;
  SeenBy<End> end_;
  bool left_ = false, right_ = false, has_end_ = false, has_line_across_ = false;
};

/// `detected` with direction and sides reversed if opposite to `predicted`.
[[nodiscard]] inline CorridorWalls facing(const CorridorWalls& detected, Angle predicted) {
  const bool against =
      std::abs(wrap_to_pi((detected.direction - predicted).radians())) > 0.5 * std::numbers::pi;
  return against ? reversed(detected) : detected;
}

}  // namespace wayfare::corridor
