#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Core>

#include <wayfare/core/se2.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/slam/detail/motion.hpp>
#include <wayfare/slam/graph_slam.hpp>

namespace wayfare::detail {

/// Without odometry the robot may be anywhere it could get to since the last scan that was matched.
class Gap {
 public:
  /// Before a scan, this time after the last that was matched; `doubted`: not the one before it.
  void begin(double silent_s, bool doubted) { silent_s_ = silent_s, doubted_ = doubted; }
  /// Whether the scan before was not surely matched.
  [[nodiscard]] bool is_doubted() const { return doubted_; }
  [[nodiscard]] double usual_s() const { return usual_s_; }
  /// Longer than a velocity predicts.
  [[nodiscard]] bool is_wide() const { return usual_s_ > kVelocityHolds_s; }
  /// After a while without scans, unusual for the log, the robot may be farther than is searched.
  [[nodiscard]] bool is_break() const {
    if (usual_s_ > 2.0 * kVelocityHolds_s) return false;  // gaps are usual
    return silent_s_ > std::max(is_wide() ? 5.0 : 2.5, 4.0 * usual_s_);
  }
  /// Half extents of the search: m, m, rad.
  [[nodiscard]] Eigen::Vector3d reach() const {
    const double s = std::max(silent_s_, usual_s_);
    const double reach = std::min(0.5 + kSpeed_mps * s, 3.0);
    return {reach, reach, std::min(0.5 + kTurnRate_radps * s, std::numbers::pi)};
  }
  /// Of the predicted pose: three times as large as errors of predictions before, and larger after
  /// a longer silence.
  [[nodiscard]] Eigen::Vector3d sigma() const {
    const Eigen::Vector3d most = reach() / 3.0;
    if (!(usual_s_ > 0.0)) return most;
    const double longer = std::max(1.0, silent_s_ / usual_s_);
    const double along = std::max(0.3, kFactor * std::sqrt(variance_[0]));
    const double turn = std::max(0.15, kFactor * std::sqrt(variance_[1]));
    return Eigen::Vector3d(along, along, turn)
        .cwiseProduct(Eigen::Vector3d::Constant(longer))
        .cwiseMin(most);
  }

  /// A scan was taken `step_s` after the one before.
  void add_interval(double step_s) {
    // A break does not become usual.
    if (usual_s_ > 0.0)
      usual_s_ += kGain * (std::min(step_s, 3.0 * usual_s_) - usual_s_);
    else
      usual_s_ = std::min(step_s, 10.0);
  }
  /// The pose of a scan relative to its prediction.
  void add_error(const SE2d& T_predicted_found) {
    const double turn = T_predicted_found.heading().radians();
    variance_ +=
        kGain * (Eigen::Vector2d(0.5 * T_predicted_found.translation().squaredNorm(), turn * turn) -
                 variance_);
  }

 private:
  friend struct LossState;  // saves and restores it

  static constexpr double kSpeed_mps = 1.0, kTurnRate_radps = 0.7, kGain = 0.1, kFactor = 3.0;

  bool doubted_ = false;
  double silent_s_ = 0.0, usual_s_ = 0.0;
  Eigen::Vector2d variance_{0.09, 0.04};  // of errors along an axis and in heading
};

/// Decides whether tracking is lost.
class LossDetector {
 public:
  explicit LossDetector(const GraphSlamOptions& options) : options_(options) {}

  [[nodiscard]] const Gap& gap() const { return gap_; }
  /// Time of the last scan that was surely matched.
  [[nodiscard]] LogTime matched_at() const { return matched_at_; }

  /// Of the first scan of a piece.
  void begin(LogTime time) {
    unsure_ = 0;
    matched_at_ = last_scan_ = time;
  }
  /// Before a scan is tracked.
  void expect(LogTime time) {
    gap_.begin(to_seconds(time - matched_at_), matched_at_ != last_scan_);
  }

  /// Whether tracking is lost with this scan: after several scans in a row that were not matched,
  /// or one after a break.
  [[nodiscard]] bool is_lost(bool found, const Motion& motion) {
    unsure_ = found ? 0 : unsure_ + 1;
    if (found) return false;
    if (motion.measured) return unsure_ >= options_.lost_scans;
    return unsure_ >= options_.lost_scans_without_odometry || gap_.is_break();
  }
  /// A scan was tracked; if `found`, this far from the prediction.
  void add(LogTime time, bool found, const Motion& motion, const SE2d& T_predicted_found) {
    if (found && !motion.measured && matched_at_ == last_scan_) gap_.add_error(T_predicted_found);
    if (found) matched_at_ = time;
    gap_.add_interval(to_seconds(time - last_scan_));
    last_scan_ = time;
  }

  /// Whether odometry moves farther than a robot drives, and contradicts the velocity by as much:
  /// its counter was set, or the robot carried.
  [[nodiscard]] static bool leaps(const Motion& odometry, const Motion& by_velocity,
                                  double step_s) {
    if (!odometry.measured) return false;
    const double change_m =
        (odometry.increment.translation() - by_velocity.increment.translation()).norm();
    return std::min(change_m, odometry.increment.translation().norm()) > 1.5 + 3.0 * step_s;
  }

 private:
  friend struct LossState;  // saves and restores it

  GraphSlamOptions options_;
  Gap gap_;
  LogTime matched_at_;  // the last scan that was surely
  LogTime last_scan_;
  int unsure_ = 0;  // scans since the last that was matched surely
};

}  // namespace wayfare::detail
