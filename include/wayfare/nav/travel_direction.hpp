#pragma once

// Forward or backward: the sign of wheel speeds that were counted without sign, from laser scans.

#include <span>
#include <vector>

#include <wayfare/core/frame.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/nav/corridor_ins.hpp>
#include <wayfare/sensors/recording.hpp>

namespace wayfare {

/// Noise and limits of a TravelDirection.
struct TravelDirectionOptions {
  double turn_error_rad = 0.17;        ///< largest error of a turn between two scans
  double least_distance_m = 0.01;      ///< of a step that is compared
  double point_sigma_m = 0.05;         ///< of a point about the surface of the other scan
  double far_m = 0.2;                  ///< points farther from it count as this far
  double independent_points = 15;      ///< in a scan: neighbours have common errors
  double greatest_log_odds = 4.0;      ///< of one step
  double reversal_probability = 0.01;  ///< of one step
};

/// The direction of travel by a hidden Markov model of two states: the points of each scan are
/// moved by the wheels' distance ahead and back, each with the turn that suits best, and compared
/// with the surfaces of the next. Causal; a bare corridor does not tell, and the direction is kept.
class TravelDirection {
 public:
  /// Forward at first; `T_base_laser` is the mounting of the laser.
  explicit TravelDirection(const TravelDirectionOptions& options = {},
                           const Transform2<frame::Base, frame::Laser>& T_base_laser = {})
      : options_(options), T_base_laser_(T_base_laser.raw()) {}

  /// The next scan, after a distance without sign, m, and a turn, rad. Returns 1 or −1 for forward
  /// or backward; motion that is not finite is as none.
  int add(const LaserScan& scan, double distance_m, double turn_rad);
  /// Natural logarithm of the odds of forward.
  [[nodiscard]] double log_odds() const { return log_odds_; }

 private:
  [[nodiscard]] double cost(double distance_m, double turn_rad) const;
  [[nodiscard]] double least_cost(double distance_m, double turn_rad) const;

  TravelDirectionOptions options_;
  SE2d T_base_laser_;
  std::vector<Eigen::Vector2d> before_;
  LaserScan now_;
  std::vector<Eigen::Vector2d> now_points_;
  double log_odds_ = 4.0;
};

/// Whether the wheels or the odometry never count backwards: at most one sample in a thousand.
[[nodiscard]] bool counts_without_sign(std::span<const MotionSample> motion);

/// Motion whose speeds are negative where the robot drove backward.
struct SignedMotion {
  std::vector<MotionSample> motion;  ///< in order of time
  std::size_t reversed = 0;          ///< number of samples whose speed changed its sign
};
/// The motion with speeds signed by TravelDirection, from the scans of the recording.
[[nodiscard]] SignedMotion sign_motion(const Recording& recording,
                                       std::span<const MotionSample> motion,
                                       const TravelDirectionOptions& options = {});

}  // namespace wayfare
