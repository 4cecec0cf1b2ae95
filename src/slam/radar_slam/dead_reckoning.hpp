#pragma once

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
  void set(const std::string& what, bool present, LogTime time);
  /// Faults that lasted at least `shortest`, by their beginning.
  [[nodiscard]] std::vector<SensorFault> faults(Duration shortest) const;

 private:
  std::vector<SensorFault> all_;
  std::map<std::string, std::size_t> open_;
};

/// The sum of heading corrections is −b T plus noise of variance q T + 2 R: q the gyro's random
/// walk, R a matched heading's.
class GyroBias {
 public:
  GyroBias(const GyroBiasOptions& options, double angle_random_walk_rad_per_sqrt_s);

  /// Adds a match's heading correction after `interval_s` seconds of bias-corrected motion.
  void learn(double turn_correction_rad, double interval_s);
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
  DeadReckoner(const DeadReckoningOptions& options, double wheel_base_m);

  [[nodiscard]] Gaussian<SE2d> increment(const SyncedStep& step, FaultLog& faults);
  /// Adds the outcome of a scan at its end.
  void learn(const RbpfOutcome& outcome);
  [[nodiscard]] double gyro_bias_rad_s() const { return bias_.rad_s(); }

 private:
  enum class Stuck { none, left, right };
  [[nodiscard]] Stuck stuck(const SyncedStep& step);
  [[nodiscard]] Gaussian<SE2d> coasting(const SyncedStep& step, double dt) const;
  [[nodiscard]] double turn_rate(const SyncedStep& step) const;
  [[nodiscard]] Gaussian<SE2d> by_gyro(double along_m, const SyncedStep& step, double dt) const;

  DeadReckoningOptions options_;
  GyroBias bias_;
  double since_match_s_ = 0.0;
  bool gyro_throughout_ = true;
  double left_m_ = 0.0, right_m_ = 0.0, turned_rad_ = 0.0;  // since both wheels last rolled
  double speed_m_s_ = 0.0;
};

}  // namespace wayfare
