#include "dead_reckoning.hpp"

#include <algorithm>
#include <cmath>

namespace wayfare {

void FaultLog::tell(const std::string& what, bool so, LogTime time) {
  const auto open = open_.find(what);
  if (open != open_.end()) all_[open->second].until = time;
  if (so && open == open_.end()) {
    open_[what] = all_.size();
    all_.push_back({what, time, time});
  }
  if (!so && open != open_.end()) open_.erase(open);
}

std::vector<SensorFault> FaultLog::faults(Duration shortest) const {
  std::vector<SensorFault> result;
  for (const SensorFault& f : all_)
    if (f.until - f.from >= shortest) result.push_back(f);
  return result;
}

DeadReckoner::DeadReckoner(const DeadReckoningOptions& options, double wheel_base_m)
    : options_(options) {
  options_.wheels.wheel_base_m = wheel_base_m > 0 ? wheel_base_m : options.wheels.wheel_base_m;
}

/// A wheel that counts exactly nothing while the other rolls, which would turn the robot, and the
/// gyro sees less than half of that turn.
DeadReckoner::Stuck DeadReckoner::stuck(const SyncedStep& step) {
  const double dt = to_seconds(step.since);
  const bool both = step.wheels.left_m != 0 && step.wheels.right_m != 0;
  if (both || !step.wheels_known || !step.gyro_known) {
    left_m_ = right_m_ = turned_rad_ = 0.0;
    return Stuck::none;
  }
  left_m_ += step.wheels.left_m;
  right_m_ += step.wheels.right_m;
  turned_rad_ += step.gyro.turn_rate_rad_s * dt;
  const double implied = (right_m_ - left_m_) / options_.wheels.wheel_base_m;
  if (std::max(std::abs(left_m_), std::abs(right_m_)) < options_.stuck_after_m ||
      std::abs(turned_rad_ - implied) < 0.5 * std::abs(implied))
    return Stuck::none;
  if (left_m_ == 0) return Stuck::left;
  return right_m_ == 0 ? Stuck::right : Stuck::none;
}

/// As fast as before, believed less and less.
Gaussian<SE2d> DeadReckoner::coasting(const SyncedStep& step, double dt) const {
  constexpr double kAcceleration = 0.3;  // m/s² a robot may brake or start with
  GyroMotion gyro = options_.gyro;
  const double along = speed_m_s_ * dt;
  const double spread = 0.5 * std::abs(speed_m_s_) * dt + kAcceleration * dt * dt;
  Gaussian<SE2d> g = gyro(along, step.gyro_known ? step.gyro.turn_rate_rad_s : 0.0, dt);
  g.covariance(0, 0) += spread * spread;
  g.covariance(1, 1) += 0.01 * spread * spread;
  if (!step.gyro_known) g.covariance(2, 2) += 0.25 * dt * dt;
  return g;
}

Gaussian<SE2d> DeadReckoner::increment(const SyncedStep& step, FaultLog& faults) {
  const double dt = to_seconds(step.since);
  const Stuck which = stuck(step);
  if (dt > 0) {
    faults.tell("wheels silent", !step.wheels_known, step.time);
    faults.tell("gyro silent or not finite", !step.gyro_known, step.time);
    faults.tell("left wheel stuck", which == Stuck::left, step.time);
    faults.tell("right wheel stuck", which == Stuck::right, step.time);
  }
  if (!step.wheels_known) return coasting(step, dt);
  double left = step.wheels.left_m, right = step.wheels.right_m;
  if (!step.gyro_known) {
    speed_m_s_ = dt > 0 ? 0.5 * (left + right) / dt : 0.0;
    return options_.wheels(left, right);
  }
  const double turn = step.gyro.turn_rate_rad_s * dt, base = options_.wheels.wheel_base_m;
  if (which == Stuck::left) left = right - turn * base;
  if (which == Stuck::right) right = left + turn * base;
  const double along = 0.5 * (left + right);
  speed_m_s_ = dt > 0 ? along / dt : 0.0;
  const Gaussian<SE2d> by_gyro = options_.gyro(along, step.gyro.turn_rate_rad_s, dt);
  if (which != Stuck::none) return by_gyro;
  const auto both = fuse(options_.wheels(left, right), by_gyro);
  return both ? *both : by_gyro;
}

}  // namespace wayfare
