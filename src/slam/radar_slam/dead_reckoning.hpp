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

/// The sum of heading corrections is −b T plus noise of variance q T + 2 R: q the gyro's random
/// walk, R a matched heading's.
class GyroBias {
 public:
  GyroBias(const GyroBiasOptions& options, double angle_random_walk_rad_per_sqrt_s)
      : options_(options),
        walk_(angle_random_walk_rad_per_sqrt_s),
        variance_(options.prior_rad_s * options.prior_rad_s) {}

  /// Adds a match's heading correction after `interval_s` seconds of bias-corrected motion.
  void learn(double turn_correction_rad, double interval_s) {
    const double prior = options_.prior_rad_s * options_.prior_rad_s;
    if (!(prior > 0) || !(interval_s > 0) ||
        std::abs(turn_correction_rad) > options_.max_correction_rad)
      return;
    const double decay = std::exp(-interval_s / options_.correlation_time_s);
    drift_rad_ = decay * drift_rad_ + turn_correction_rad - rad_s_ * interval_s;
    time_s_ = decay * time_s_ + interval_s;
    const double noise =
        walk_ * walk_ * time_s_ + 2.0 * options_.heading_rad * options_.heading_rad;
    variance_ = 1.0 / (1.0 / prior + time_s_ * time_s_ / noise);
    rad_s_ = -variance_ * time_s_ / noise * drift_rad_;
  }

  [[nodiscard]] double rad_s() const { return rad_s_; }
  [[nodiscard]] double variance() const { return variance_; }

 private:
  GyroBiasOptions options_;
  double walk_;
  double drift_rad_ = 0.0, time_s_ = 0.0;
  double rad_s_ = 0.0, variance_;
};

/// Step 4: the product of wheel and gyro model, or one of them when the other fails.
class DeadReckoner {
 public:
  DeadReckoner(const DeadReckoningOptions& options, double wheel_base_m)
      : options_(options), bias_(options.gyro_bias, options.gyro.angle_random_walk_rad_per_sqrt_s) {
    if (wheel_base_m > 0) options_.wheels.wheel_base_m = wheel_base_m;
  }

  [[nodiscard]] Gaussian<SE2d> increment(const SyncedStep& step, FaultLog& faults) {
    const double dt = to_seconds(step.since);
    const Stuck which = stuck(step);
    since_match_s_ += dt;
    gyro_throughout_ = gyro_throughout_ && (step.gyro_known || !(dt > 0));
    if (dt > 0) {
      faults.set("wheels silent", !step.wheels_known, step.time);
      faults.set("gyro silent or not finite", !step.gyro_known, step.time);
      faults.set("left wheel stuck", which == Stuck::left, step.time);
      faults.set("right wheel stuck", which == Stuck::right, step.time);
    }
    if (!step.wheels_known) return coasting(step, dt);
    double left = step.wheels.left_m, right = step.wheels.right_m;
    if (!step.gyro_known) {
      speed_m_s_ = dt > 0 ? 0.5 * (left + right) / dt : 0.0;
      return options_.wheels(left, right);
    }
    const double turn = turn_rate(step) * dt, base = options_.wheels.wheel_base_m;
    if (which == Stuck::left) left = right - turn * base;
    if (which == Stuck::right) right = left + turn * base;
    const double along = 0.5 * (left + right);
    speed_m_s_ = dt > 0 ? along / dt : 0.0;
    const Gaussian<SE2d> turned = by_gyro(along, step, dt);
    if (which != Stuck::none) return turned;
    const auto both = fuse(options_.wheels(left, right), turned);
    return both ? *both : turned;
  }

  /// Adds the outcome of a scan at its end.
  void learn(const RbpfOutcome& outcome) {
    if (!outcome.updated) return;
    if (outcome.matched > 0 && gyro_throughout_)
      bias_.learn(outcome.turn_correction.radians(), since_match_s_);
    since_match_s_ = 0.0;
    gyro_throughout_ = true;
  }

  [[nodiscard]] double gyro_bias_rad_s() const { return bias_.rad_s(); }

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
    return step.gyro_known ? step.gyro.turn_rate_rad_s - bias_.rad_s() : 0.0;
  }

  [[nodiscard]] Gaussian<SE2d> by_gyro(double along_m, const SyncedStep& step, double dt) const {
    Gaussian<SE2d> g = options_.gyro(along_m, turn_rate(step), dt);
    const GyroBiasOptions& bias = options_.gyro_bias;
    if (bias.prior_rad_s > 0)
      g.covariance(2, 2) +=
          std::max(bias_.variance(), bias.min_sigma_rad_s * bias.min_sigma_rad_s) *
          bias.residual_time_s * dt;
    return g;
  }

  DeadReckoningOptions options_;
  GyroBias bias_;
  double since_match_s_ = 0.0;
  bool gyro_throughout_ = true;
  double left_m_ = 0.0, right_m_ = 0.0, turned_rad_ = 0.0;  // since both wheels last rolled
  double speed_m_s_ = 0.0;
};

}  // namespace wayfare
