#include "robot.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace wayfare {
namespace {

constexpr double kMetresPerCell = 0.5;
constexpr int kCrossings = 5;      // of the lattice in each direction
constexpr double kFirst_m = 6.0;   // of the first crossing, from the plan's corner
constexpr double kApart_m = 22.0;  // crossings

struct Floor {
  int width, height;
  std::vector<bool> solid = std::vector<bool>(static_cast<std::size_t>(width * height), true);

  void clear(double x_m, double y_m, double width_m, double height_m) {
    const auto cells = [](double m) { return static_cast<int>(std::lround(m / kMetresPerCell)); };
    for (int y = std::max(1, cells(y_m)); y < std::min(height - 1, cells(y_m + height_m)); ++y)
      for (int x = std::max(1, cells(x_m)); x < std::min(width - 1, cells(x_m + width_m)); ++x)
        solid[static_cast<std::size_t>(y * width + x)] = false;
  }
  [[nodiscard]] Result<sim::FloorPlan> plan() const {
    sim::CellMask mask;
    mask.width = width;
    mask.height = height;
    mask.cell_m = kMetresPerCell;
    mask.solid.assign(solid.begin(), solid.end());
    return sim::FloorPlan::from_cells(mask);
  }
};

Eigen::Vector2d crossing_m(int column, int row) {
  return {kFirst_m + kApart_m * column, kFirst_m + kApart_m * row};
}

}  // namespace

Result<sim::FloorPlan> building_plan(const Rng& seed) {
  Rng rng = seed;
  Floor mask{200, 200};
  const double last_m = kFirst_m + kApart_m * (kCrossings - 1);
  for (int i = 0; i < kCrossings; ++i) {
    const double at_m = kFirst_m + kApart_m * i - 2.0;
    mask.clear(at_m, kFirst_m - 2.0, 4.0, last_m - kFirst_m + 4.0);
    mask.clear(kFirst_m - 2.0, at_m, last_m - kFirst_m + 4.0, 4.0);
  }
  for (int i = 0; i < 160; ++i)
    mask.clear(rng.uniform(2.0, 94.0), rng.uniform(2.0, 94.0), rng.uniform(1.0, 6.0),
               rng.uniform(1.0, 6.0));
  return mask.plan();
}

Result<sim::FloorPlan> corridor_plan(double length_m, const Rng& seed) {
  Rng rng = seed;
  Floor mask{static_cast<int>(length_m / kMetresPerCell), 40};
  mask.clear(2.0, 8.0, length_m, 4.0);
  for (double x_m = 4.0; x_m < length_m; x_m += rng.uniform(2.0, 10.0))
    mask.clear(x_m, rng.uniform(4.0, 11.0), rng.uniform(1.0, 4.0), rng.uniform(1.0, 5.0));
  return mask.plan();
}

EndlessRobot::EndlessRobot(const sim::FloorPlan& plan, bool returns, double scan_period_s,
                           const Rng& rng)
    : plan_(plan),
      returns_(returns),
      scan_period_s_(scan_period_s),
      rng_(rng.stream(1)),
      noise_(rng.stream(2)),
      truth_(returns ? SE2d(crossing_m(0, 0).x(), crossing_m(0, 0).y(), Angle{})
                     : SE2d(6.0, 10.0, Angle{})),
      odometry_(truth_) {
  choose_waypoint();
}

LogTime EndlessRobot::time() const {
  return LogTime() + from_seconds(static_cast<double>(scans_) * scan_period_s_);
}

void EndlessRobot::choose_waypoint() {
  if (!returns_) {
    waypoint_m_ = {1e9, 10.0};
    return;
  }
  struct Place {
    int column, row;
  };
  std::vector<Place> next;
  for (const Place p : {Place{column_ + 1, row_}, Place{column_, row_ + 1},
                        Place{column_ - 1, row_}, Place{column_, row_ - 1}})
    if (p.column >= 0 && p.row >= 0 && p.column < kCrossings && p.row < kCrossings &&
        !(p.column == from_column_ && p.row == from_row_))
      next.push_back(p);
  const Place chosen = next[rng_.below(next.size())];
  from_column_ = column_;
  from_row_ = row_;
  column_ = chosen.column;
  row_ = chosen.row;
  // Not always along the same line.
  waypoint_m_ =
      crossing_m(column_, row_) + Eigen::Vector2d(rng_.uniform(-0.8, 0.8), rng_.uniform(-0.8, 0.8));
}

/// Wheels that slip, and a gyro with noise.
void EndlessRobot::move(double length_m, double turn_rad) {
  constexpr double kSlip = 0.02, kTurn = 0.02, kTurnPerRootMetre_rad = 0.004;
  truth_ = truth_ * SE2d(length_m, 0.0, Angle::radians(turn_rad));
  const double slip = 1.0 + kSlip * noise_.normal();
  const double turn = turn_rad * (1.0 + kTurn * noise_.normal()) +
                      kTurnPerRootMetre_rad * std::sqrt(length_m) * noise_.normal();
  odometry_ = odometry_ * SE2d(length_m * slip, 0.0, Angle::radians(turn));
  travelled_m_ += length_m;
}

void EndlessRobot::advance() {
  constexpr double kStep_s = 0.1, kSpeed_m_s = 0.5, kTurnRate_rad_s = 0.8;
  for (double left_s = scan_period_s_; left_s > 1e-9; left_s -= kStep_s) {
    const Eigen::Vector2d ahead = truth_.inverse() * waypoint_m_;
    if (ahead.norm() < 0.2) {
      choose_waypoint();
      continue;
    }
    const double wrong_rad = std::atan2(ahead.y(), ahead.x());
    const double most_rad = kTurnRate_rad_s * kStep_s;
    const double turn_rad = std::clamp(wrong_rad, -most_rad, most_rad);
    const bool straight = std::abs(wrong_rad) < 0.3;
    move(straight ? std::min(kSpeed_m_s * kStep_s, ahead.norm()) : 0.0, turn_rad);
  }
  ++scans_;
}

LaserScan EndlessRobot::scan() const {
  Rng rng = noise_.stream(scans_);
  return sim::simulate_scan(
      plan_, [this](LogTime) { return truth_; }, time(), {}, rng);
}

}  // namespace wayfare
