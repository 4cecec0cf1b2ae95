#pragma once

// The navigation filter beside Hector SLAM (Kohlbrecher et al. 2011, section IV): six degrees of
// freedom from an inertial unit, held by what a scan matcher finds in the plane.

#include <cstddef>
#include <optional>

#include <Eigen/Core>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/core/so3.hpp>
#include <wayfare/filter/ekf.hpp>
#include <wayfare/inertial/attitude.hpp>
#include <wayfare/inertial/detail/rest_detector.hpp>
#include <wayfare/inertial/detail/sample_clock.hpp>
#include <wayfare/sensors/imu.hpp>
#include <wayfare/slam/detail/carrier_motion.hpp>

namespace wayfare {

struct CarrierFilterParameters {
  CarrierNoise noise{};
  /// The floor is level: height and vertical velocity about zero are a process of this standard
  /// deviation and correlation time, m, m/s and s: a head's bob.
  double height_sigma_m = 0.05, climb_sigma_mps = 0.3, height_time_s = 0.5;
  /// Horizontal velocity is never less known than this, m/s, about zero: nobody on foot is faster
  /// than a few. Keeps the plumb line where no match does.
  double speed_sigma_mps = 1.5;
  /// At rest is who keeps rate (rad/s) and specific force (m/s²) this near to their averages for
  /// this long, s, and whose average rate could be a bias; velocity is then zero to this, m/s.
  double rest_rate = 0.035, rest_force = 0.5, rest_time_s = 1.5, rest_bias_limit = 0.05;
  double rest_sigma_mps = 0.02, rest_rate_density = 0.0005;
  /// A longer pause, s, begins level and velocity anew. Scans later than `silence_s` after the last
  /// reading are none of the unit's.
  double restart_gap_s = 0.5, silence_s = 0.3;
  /// Matches taken as measurements whose errors have nothing to do with the state's. They have: the
  /// map was drawn from where the state said the scans were, and each match starts from it.
  bool independent_matches = false;
  /// Mean horizontal acceleration, m/s², that nobody sustains for a second: the level is lost.
  double lost_level_mps2 = 4.0;
};

/// Fed readings in the body's axes (x forward, z up) and matches, in order of time. Errors are
/// those of CarrierState.
class CarrierFilter {
 public:
  using Square = CarrierModel::Square;

  explicit CarrierFilter(const CarrierFilterParameters& parameters = {});

  /// `late` and `missing` readings change nothing; `waiting`: no level could be had from it yet.
  UpdateStatus add(const ImuSample& sample);

  /// Whether there is an attitude, and readings of the time about `time`.
  [[nodiscard]] bool tells_of(LogTime time) const;
  /// Goes on to `time` as the last reading says; nothing where it lies before the last reading.
  void advance(LogTime time);
  /// Whether the plane's position and heading have been given since the level was begun.
  [[nodiscard]] bool placed() const { return placed_; }
  /// The body is at `T_map_base`, so exactly: m and rad. Level, biases and speed are kept.
  void place(const SE2d& T_map_base, double sigma_m, Angle sigma);
  /// Takes a match in by covariance intersection, its covariance in the matched pose's own axes;
  /// the weight ω it was given, none where it could not be used.
  std::optional<double> fuse(const SE2d& T_map_base, const Eigen::Matrix3d& covariance);

  [[nodiscard]] const CarrierState& state() const { return ekf_.state(); }
  [[nodiscard]] const Square& covariance() const { return ekf_.covariance(); }
  [[nodiscard]] SE2d planar() const { return state().planar(); }
  /// Of `planar()`, in its own axes.
  [[nodiscard]] Eigen::Matrix3d planar_covariance() const;
  /// Turns the body's axes to level ones whose x is the heading.
  [[nodiscard]] SO3d q_level_body() const;
  [[nodiscard]] bool at_rest() const;
  /// How far the plumb line may be off, σ about the worse axis.
  [[nodiscard]] Angle level_sigma() const;
  /// How often level and velocity were begun.
  [[nodiscard]] std::size_t starts() const { return starts_; }

 private:
  void start(const ImuSample& sample);
  void step(const ImuSample& from, const ImuSample& to);
  void hold(double elapsed_s);
  void hold_at_rest(double elapsed_s);
  bool lost(const ImuSample& sample, double dt_s);

  CarrierFilterParameters p_;
  CarrierModel model_;
  Ekf<CarrierState> ekf_;
  RestDetector<double> rest_;
  SampleClock clock_{1.0};
  std::optional<ImuSample> last_;  // reading
  LogTime time_;                   // of the state
  bool placed_ = false;
  double since_hold_s_ = 0.0, lost_s_ = 0.0;
  Eigen::Vector3d mean_force_ = Eigen::Vector3d::Zero();  // map axes, over a second
  std::size_t starts_ = 0;
};

}  // namespace wayfare
