#pragma once

// The walls in the filter's state: predicted measurements, and augmentation by new walls.

#include <optional>

#include <Eigen/Core>

#include <wayfare/core/se2.hpp>
#include <wayfare/filter/ekf.hpp>
#include <wayfare/match/lines.hpp>
#include <wayfare/nav/detail/corridor_motion.hpp>

namespace wayfare::corridor {

using Filter = Ekf<CorridorVector>;
using Rows = Eigen::Matrix<double, Eigen::Dynamic, corridor_state::kSize>;

/// Predicted wall measurements and their Jacobians.
struct Predicted {
  CorridorWalls walls;
  Eigen::Matrix<double, 3, corridor_state::kSize> rows;      ///< of direction, left, right
  Eigen::Matrix<double, 2, corridor_state::kSize> end_rows;  ///< of α and ρ of the wall across
};

/// Walls in the state and the reference points of their offsets, which are nearby so that angle and
/// offset errors of far corridors are not fully correlated.
class WallStates {
 public:
  explicit WallStates(const SE2d& T_base_laser) : T_base_laser_(T_base_laser) {}

  [[nodiscard]] bool has_walls() const { return left_ || right_; }
  void forget_walls() { left_ = right_ = false; }
  void forget_end() { end_ = false; }

  [[nodiscard]] SE2d laser_pose(const CorridorVector& x) const;
  [[nodiscard]] Predicted predict(const Filter& filter) const;

  /// Augments the state with `detected` walls: all of them, or the missing side.
  void enter(const CorridorWalls& detected, Filter& filter);
  void enter_missing_side(const CorridorWalls& detected, Filter& filter);
  void enter_end(const NormalPoint& detected, Filter& filter);

 private:
  void replace(const Rows& by_state, const Eigen::MatrixXd& noise, const Eigen::VectorXi& entries,
               const Eigen::VectorXd& values, Filter& filter) const;

  SE2d T_base_laser_;
  Eigen::Vector2d reference_m_ = Eigen::Vector2d::Zero(),
                  end_reference_m_ = Eigen::Vector2d::Zero();
  bool left_ = false, right_ = false, end_ = false;
};

/// `detected` with direction and sides reversed if opposite to `predicted`.
[[nodiscard]] CorridorWalls facing(const CorridorWalls& detected, Angle predicted);

}  // namespace wayfare::corridor
