#pragma once

// A robot that drives for as long as asked, one scan at a time: through a building of 100 m x 100
// m, or along a corridor that does not return.

#include <cstddef>
#include <optional>

#include <Eigen/Core>

#include <wayfare/core/random.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/sim/floor_plan.hpp>

namespace wayfare {

/// The building's corridors are a lattice, 4 m wide, with rooms and niches along them.
[[nodiscard]] Result<sim::FloorPlan> building_plan(const Rng& rng);
/// A corridor of this length, with niches.
[[nodiscard]] Result<sim::FloorPlan> corridor_plan(double length_m, const Rng& rng);

/// Turns on the spot and drives straight, from crossing to crossing chosen at random, or ahead. The
/// n-th scan depends only on the seed and n.
class EndlessRobot {
 public:
  EndlessRobot(const sim::FloorPlan& plan, bool returns, double scan_period_s, const Rng& rng);

  /// To the time of the next scan.
  void advance();
  [[nodiscard]] LaserScan scan() const;
  /// In the plan's frame; odometry starts there too.
  [[nodiscard]] const SE2d& truth() const { return truth_; }
  [[nodiscard]] const SE2d& odometry() const { return odometry_; }
  [[nodiscard]] double travelled_m() const { return travelled_m_; }
  [[nodiscard]] LogTime time() const;

 private:
  void choose_waypoint();
  void move(double length_m, double turn_rad);

  const sim::FloorPlan& plan_;
  bool returns_;
  double scan_period_s_;
  Rng rng_, noise_;
  std::size_t scans_ = 0;
  int column_ = 0, row_ = 0, from_column_ = -1, from_row_ = -1;
  Eigen::Vector2d waypoint_m_;
  SE2d truth_, odometry_;
  double travelled_m_ = 0.0;
};

}  // namespace wayfare
