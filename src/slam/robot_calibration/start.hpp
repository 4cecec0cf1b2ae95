#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/core/statistics.hpp>

#include "slam/robot_calibration/base_motion.hpp"

namespace wayfare::calibration {

/// A velocity of a sensor in its own axes, with its turn rate where it has one (else NaN).
struct SensorVelocity {
  double time_s = 0.0;
  Eigen::Vector2d velocity_m_s;
  double turn_rate_rad_s = std::numeric_limits<double>::quiet_NaN();
};

/// Of a mounting and a delay, with how much of the velocities' variance it explains.
struct MountingStart {
  SE2d T_base_sensor;
  double delay_s = 0.0;
  double cost = std::numeric_limits<double>::infinity();
  double speed_ratio = 1.0;  ///< the sensor's speeds over those of the base
  double turn_ratio = 1.0;   ///< likewise, NaN where the sensor has no turn rate or nothing turned
};

/// Sums of the regression of velocities on the base's twist: vx = c v + p ω, vy = −s v + q ω for
/// a base that rolls along x; and with a base whose motion is free, a scaled rotation.
class VelocityRegression {
 public:
  void add(const SensorVelocity& sensor, const Eigen::Vector3d& twist, double weight) {
    // v_sensor = Rᵀ (v + ω × l) is linear in Rᵀ = [a b; −b a] and Rᵀ (−l_y, l_x).
    const double vx = twist[0], vy = twist[1], w = twist[2];
    const Eigen::Vector4d row_x(vx, vy, w, 0.0), row_y(vy, -vx, 0.0, w);
    normal_ += weight * (row_x * row_x.transpose() + row_y * row_y.transpose());
    right_ += weight * (sensor.velocity_m_s.x() * row_x + sensor.velocity_m_s.y() * row_y);
  }
  [[nodiscard]] Eigen::Vector4d solution() const {
    Eigen::Matrix4d damped = normal_;
    // Without turns the lever arm is zero.
    damped.diagonal().tail<2>().array() += 1e-3 * normal_.trace() + 1e-12;
    damped.diagonal().head<2>().array() += 1e-9 * normal_.trace() + 1e-12;
    return damped.ldlt().solve(right_);
  }

 private:
  Eigen::Matrix4d normal_ = Eigen::Matrix4d::Zero();
  Eigen::Vector4d right_ = Eigen::Vector4d::Zero();
};

inline Eigen::Vector2d predicted(const Eigen::Vector4d& x, const Eigen::Vector3d& t) {
  return {x[0] * t[0] + x[1] * t[1] + x[2] * t[2], x[0] * t[1] - x[1] * t[0] + x[3] * t[2]};
}

/// Sums of the turn rates of both, over instants at which one of them turns: unequal wheels make a
/// straight drive look like a slow turn.
struct Turns {
  double base_rad = 0.0, together_rad = 0.0, differences_rad = 0.0;
  int count = 0;
  void add(double sensor, double base) {
    constexpr double kTurns_rad_s = 0.15;
    differences_rad += std::abs(sensor - base);
    if (std::max(std::abs(sensor), std::abs(base)) < kTurns_rad_s) return;
    ++count;
    base_rad += std::abs(base);
    together_rad += sensor * (base < 0.0 ? -1.0 : 1.0);
  }
  [[nodiscard]] double ratio() const {
    constexpr int kFewest = 10;
    return count >= kFewest && base_rad > 0.0 ? together_rad / base_rad
                                              : std::numeric_limits<double>::quiet_NaN();
  }
};

/// The linear fit for one delay, weighted again twice by its residuals.
inline MountingStart start_at(const BaseMotion& base, std::span<const SensorVelocity> all,
                              const Eigen::Vector3d& wheels, double delay_s) {
  std::vector<Eigen::Vector3d> twists;
  std::vector<std::size_t> used;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const double t = all[i].time_s - delay_s;
    if (!base.covers(t, t)) continue;
    twists.push_back(base.twist_at(t, wheels));
    used.push_back(i);
  }
  MountingStart start;
  start.delay_s = delay_s;
  if (used.size() < 20) return start;
  std::vector<double> weight(used.size(), 1.0), residual(used.size());
  Eigen::Vector4d x = Eigen::Vector4d::Zero();
  for (int round = 0; round < 4; ++round) {
    VelocityRegression fit;
    for (std::size_t i = 0; i < used.size(); ++i) fit.add(all[used[i]], twists[i], weight[i]);
    x = fit.solution();
    for (std::size_t i = 0; i < used.size(); ++i)
      residual[i] = (all[used[i]].velocity_m_s - predicted(x, twists[i])).norm();
    const double scale = std::max(1.5 * median_of(residual), 1e-4);
    for (std::size_t i = 0; i < used.size(); ++i)
      weight[i] = 1.0 / (1.0 + residual[i] * residual[i] / (scale * scale));
  }
  start.cost = 0.0;
  Turns turns;
  for (std::size_t i = 0; i < used.size(); ++i) {
    start.cost += std::min(residual[i], 1.0);
    const double w = all[used[i]].turn_rate_rad_s;
    if (std::isfinite(w)) turns.add(w, twists[i][2]);
  }
  // A laser's turn rate shows the delay best.
  start.cost = (start.cost + turns.differences_rad) / static_cast<double>(used.size());
  start.speed_ratio = std::hypot(x[0], x[1]);
  start.turn_ratio = turns.ratio();
  const Angle yaw = Angle::radians(std::atan2(x[1], x[0]));
  const double scale = start.speed_ratio > 1e-9 ? start.speed_ratio : 1.0;
  const Eigen::Vector2d cross = SO2d(yaw) * Eigen::Vector2d(x[2], x[3]) / scale;
  start.T_base_sensor = SE2d(cross.y(), -cross.x(), yaw);
  return start;
}

/// The best of all delays up to `max_delay_s`, on a grid of 20 ms and then of 4 ms.
inline MountingStart find_start(const BaseMotion& base, std::span<const SensorVelocity> all,
                                const Eigen::Vector3d& wheels, double max_delay_s) {
  MountingStart best = start_at(base, all, wheels, 0.0);
  const auto search = [&](double centre, double half, double step) {
    for (double d = centre - half; d <= centre + half + 1e-9; d += step) {
      const MountingStart start = start_at(base, all, wheels, d);
      if (start.cost < best.cost) best = start;
    }
  };
  search(0.0, max_delay_s, 0.02);
  search(best.delay_s, 0.016, 0.004);
  return best;
}

/// Why two sensors contradict each other, from the ratios of what they report; empty: they do not.
std::string contradiction(const std::string& sensor, const std::string& base, double speed_ratio,
                          double turn_ratio);

}  // namespace wayfare::calibration
