#pragma once

// The walls in the filter's state: what a scan should show of them, and how one enters.

#include <optional>

#include <Eigen/Core>

#include <wayfare/core/se2.hpp>
#include <wayfare/filter/ekf.hpp>
#include <wayfare/match/lines.hpp>
#include <wayfare/nav/detail/corridor_motion.hpp>

namespace wayfare::corridor {

using Filter = Ekf<CorridorVector>;
using Rows = Eigen::Matrix<double, Eigen::Dynamic, corridor_state::kSize>;

/// Measurements of walls at a state: what they should be, and their derivatives.
struct Predicted {
  CorridorWalls walls;
  Eigen::Matrix<double, 3, corridor_state::kSize> rows;      ///< of direction, left, right
  Eigen::Matrix<double, 2, corridor_state::kSize> end_rows;  ///< of α and ρ of the wall across
};

/// Which walls the state knows, and the places their offsets count from. (Offsets from a place
/// nearby keep angles and offsets of far corridors from being all one error.)
class WallStates {
 public:
  explicit WallStates(const SE2d& T_base_laser) : T_base_laser_(T_base_laser) {}

  [[nodiscard]] bool has_walls() const { return left_ || right_; }
  [[nodiscard]] bool has_end() const { return end_; }
  void forget_walls() { left_ = right_ = false; }
  void forget_end() { end_ = false; }

  [[nodiscard]] SE2d laser_pose(const CorridorVector& x) const;
  [[nodiscard]] Predicted predict(const Filter& filter) const;

  /// New walls as `seen` from the filter's place: all of them, or the side that is not yet known.
  void enter(const CorridorWalls& seen, Filter& filter);
  void enter_missing_side(const CorridorWalls& seen, Filter& filter);
  void enter_end(const NormalPoint& seen, Filter& filter);

 private:
  void replace(const Rows& by_state, const Eigen::MatrixXd& noise, const Eigen::VectorXi& entries,
               const Eigen::VectorXd& values, Filter& filter) const;

  SE2d T_base_laser_;
  Eigen::Vector2d place_m_ = Eigen::Vector2d::Zero(), end_place_m_ = Eigen::Vector2d::Zero();
  bool left_ = false, right_ = false, end_ = false;
};

/// `seen` with its direction and sides exchanged where it faces against `predicted`.
[[nodiscard]] CorridorWalls facing(const CorridorWalls& seen, Angle predicted);

}  // namespace wayfare::corridor
