#pragma once

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <wayfare/core/gaussian.hpp>
#include <wayfare/slam/radar_slam.hpp>
#include <wayfare/sync/augmented_scans.hpp>

#include "slam/radar_slam/gyro_bias.hpp"

namespace wayfare {

/// Faults with their beginning and end.
class FaultLog {
 public:
  /// Sets whether `what` is present at this time.
  void set(const std::string& what, bool present, LogTime time) {
    const auto open = open_.find(what);
    if (open != open_.end()) all_[open->second].until = time;
    if (present && open == open_.end()) {
      open_[what] = all_.size();
      all_.push_back({what, time, time});
    }
    if (!present && open != open_.end()) open_.erase(open);
  }

  /// Faults that lasted at least `shortest`, by their beginning.
  [[nodiscard]] std::vector<SensorFault> faults(Duration shortest) const {
    std::vector<SensorFault> result;
    for (const SensorFault& f : all_)
      if (f.until - f.from >= shortest) result.push_back(f);
    return result;
  }

 private:
  std::vector<SensorFault> all_;
  std::map<std::string, std::size_t> open_;
};

/// Step 4: the product of wheel and gyro model, or one of them when the other fails.
class DeadReckoner {
 public:
  DeadReckoner(const DeadReckoningOptions& options, double wheel_base_m) : options_(options) {
    if (wheel_base_m > 0) options_.wheels.wheel_base_m = wheel_base_m;
  }

  [[nodiscard]] BiasedMotion increment(const SyncedStep& step, FaultLog& faults) {
    const double dt = to_seconds(step.since);
    const Stuck which = stuck(step);
    if (dt > 0) {
      faults.set("wheels silent", !step.wheels_known, step.time);
      faults.set("gyro silent or not finite", !step.gyro_known, step.time);
      faults.set("left wheel stuck", which == Stuck::left, step.time);
      faults.set("right wheel stuck", which == Stuck::right, step.time);
    }
    if (!step.wheels_known) return {coasting(step, dt), step.gyro_known ? dt : 0.0};
    double left = step.wheels.left_m, right = step.wheels.right_m;
    if (!step.gyro_known) {
      speed_m_s_ = dt > 0 ? 0.5 * (left + right) / dt : 0.0;
      return {options_.wheels(left, right)};
    }
    const double turn = turn_rate(step) * dt, base = options_.wheels.wheel_base_m;
    if (which == Stuck::left) left = right - turn * base;
    if (which == Stuck::right) right = left + turn * base;
    const double along = 0.5 * (left + right);
    speed_m_s_ = dt > 0 ? along / dt : 0.0;
    const Gaussian<SE2d> turned = by_gyro(along, step, dt);
    if (which != Stuck::none) return {turned, dt};
    const Gaussian<SE2d> rolled = options_.wheels(left, right);
    const auto both = fuse(rolled, turned);
    if (!both) return {turned, dt};
    const double wheels = rolled.covariance(2, 2), gyro = turned.covariance(2, 2);
    return {*both, dt * wheels / (wheels + gyro)};
  }

 private:
  enum class Stuck { none, left, right };

  /// A wheel is stuck if it reports exactly no motion while the other rolls, and the gyro measures
  /// less than half of the rotation which that implies.
  [[nodiscard]] Stuck stuck(const SyncedStep& step) {
    const double dt = to_seconds(step.since);
    const bool both = step.wheels.left_m != 0 && step.wheels.right_m != 0;
    if (both || !step.wheels_known || !step.gyro_known) {
      left_m_ = right_m_ = turned_rad_ = 0.0;
      return Stuck::none;
    }
    left_m_ += step.wheels.left_m;
    right_m_ += step.wheels.right_m;
    turned_rad_ += turn_rate(step) * dt;
    const double implied = (right_m_ - left_m_) / options_.wheels.wheel_base_m;
    if (std::max(std::abs(left_m_), std::abs(right_m_)) < options_.stuck_after_m ||
        std::abs(turned_rad_ - implied) < 0.5 * std::abs(implied))
      return Stuck::none;
    if (left_m_ == 0) return Stuck::left;
    return right_m_ == 0 ? Stuck::right : Stuck::none;
  }

  /// At the last speed, with growing uncertainty.
  [[nodiscard]] Gaussian<SE2d> coasting(const SyncedStep& step, double dt) const {
    constexpr double kAcceleration = 0.3;  // m/s² a robot may brake or start with
    const double along = speed_m_s_ * dt;
    const double spread = 0.5 * std::abs(speed_m_s_) * dt + kAcceleration * dt * dt;
    Gaussian<SE2d> g = by_gyro(along, step, dt);
    g.covariance(0, 0) += spread * spread;
    g.covariance(1, 1) += 0.01 * spread * spread;
    if (!step.gyro_known) g.covariance(2, 2) += 0.25 * dt * dt;
    return g;
  }

  /// 0 without gyro data.
  [[nodiscard]] double turn_rate(const SyncedStep& step) const {
    return step.gyro_known ? step.gyro.turn_rate_rad_s : 0.0;
  }

  [[nodiscard]] Gaussian<SE2d> by_gyro(double along_m, const SyncedStep& step, double dt) const {
    return options_.gyro(along_m, turn_rate(step), dt);
  }

  DeadReckoningOptions options_;
  double left_m_ = 0.0, right_m_ = 0.0, turned_rad_ = 0.0;  // since both wheels last rolled
  double speed_m_s_ = 0.0;
};

}  // namespace wayfare
