#pragma once

// Dead reckoning in space by a radar and an inertial unit carried together: attitude by the AHRS,
// velocity by the accelerometer and the radial speeds of each radar frame, position by both
// (loosely coupled; compare Doer and Trommer 2020, "An EKF based approach to radar inertial
// odometry", which estimates the attitude in the same filter).
//
// The AHRS takes the accelerometer for the vertical, which slow accelerations tilt; those that the
// radar measures, as changes of its velocity, are taken out before.
//
// State: position, velocity, and the error of the levelled specific force (tilt times gravity and
// bias of the accelerometer), a Gauss-Markov process; in world axes.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/geodesy.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/filter/ekf.hpp>
#include <wayfare/inertial/ahrs.hpp>
#include <wayfare/motion/radar_velocity.hpp>
#include <wayfare/sensors/measurements.hpp>

namespace wayfare {

/// Mounting and noise of a RadarInertialOdometry.
struct RadarInertialOptions {
  AhrsParameters ahrs{.use_magnetometer = false};     ///< of the attitude
  SO3d q_unit_radar;                                  ///< from the radar's axes to the unit's
  Eigen::Vector3d lever_m = Eigen::Vector3d::Zero();  ///< of the radar, unit's axes, m
  double gravity_mps2 = 9.807;                        ///< at the place
  /// Noise of the accelerometer, m/s²/√Hz; larger: more weight of the radar.
  double force_noise = 0.03;
  double force_error_sigma = 0.3;   ///< of the error's process, m/s²: a tilt of 1° gives 0.17
  double force_error_time_s = 5.0;  ///< its correlation time
  /// Added to the standard deviation of a frame's velocity, m/s: errors that its residuals do not
  /// show.
  double velocity_sigma_m_s = 0.02;
  double acceleration_time_s = 0.5;  ///< over which changes of the velocity are averaged
  double nis_limit = 16.3;           ///< beyond it a velocity is rejected; χ² of 3, 0.999
  double longest_rejection_s = 1.0;  ///< of all velocities; then the next one is taken as it is
  double longest_gap_s = 0.5;        ///< of the inertial readings; beyond it the motion is unknown
};

/// Position, velocity and attitude at a time; the start is the origin, its heading zero.
struct RadarInertialEstimate {
  LogTime time;                                            ///< of the reading
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();    ///< east, north, up of the start
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();  ///< east, north, up
  SO3d q_enu_unit;                                         ///< attitude
  Eigen::Matrix<double, 6, 6> covariance =
      Eigen::Matrix<double, 6, 6>::Zero();  ///< of position and velocity, given the attitude
};

/// Counts of a RadarInertialOdometry.
struct RadarInertialCounts {
  std::size_t velocities = 0;  ///< that updated the estimate
  std::size_t rejected = 0;    ///< by their innovation
  std::size_t early = 0;       ///< before there was an attitude
  std::size_t gaps = 0;        ///< of the inertial readings
};

/// Takes readings in order of time; a velocity acts at the newest inertial reading. Allocates no
/// memory. Not thread-safe.
class RadarInertialOdometry {
 public:
  /// Without readings.
  explicit RadarInertialOdometry(const RadarInertialOptions& options = {})
      : o_(options), ahrs_(options.ahrs) {
    filter_ = Filter(Vector9::Zero(), start_covariance());
  }

  /// A reading of the unit. Late ones and those that are not finite are refused, as by the AHRS.
  UpdateStatus add(const ImuSample& s) {
    const UpdateStatus rate = ahrs_.add_rate(s.time, s.angular_rate_radps);
    const Eigen::Vector3d moving =
        ahrs_.ready() ? Eigen::Vector3d(ahrs_.q_world_body().inverse() * acceleration_mps2_)
                      : Eigen::Vector3d::Zero();
    const UpdateStatus force = ahrs_.add_force(s.time, s.specific_force_mps2 - moving);
    if (rate == UpdateStatus::late || force == UpdateStatus::late ||
        rate == UpdateStatus::missing || force == UpdateStatus::missing)
      return rate == UpdateStatus::used ? force : rate;
    rate_radps_ = s.angular_rate_radps - ahrs_.gyro_bias_radps();
    if (ahrs_.ready() && time_) predict(s);
    time_ = s.time;
    return ahrs_.ready() ? UpdateStatus::used : UpdateStatus::waiting;
  }
  /// The velocity of a frame, in the radar's axes. `waiting`: no attitude yet; `disturbed`:
  /// rejected; `missing`: not finite.
  UpdateStatus add(const RadarVelocity& v) {
    if (!v.velocity_m_s.allFinite() || !v.covariance.allFinite()) return UpdateStatus::missing;
    if (!time_ || !ahrs_.ready()) {
      ++counts_.early;
      return UpdateStatus::waiting;
    }
    const VelocityError measured = levelled(v);
    const double limit = rejected_for_s_ > o_.longest_rejection_s
                             ? std::numeric_limits<double>::max()
                             : o_.nis_limit;
    if (filter_.update(measured, limit).accepted) {
      ++counts_.velocities;
      rejected_for_s_ = 0.0;
      accelerate(measured.velocity_m_s);
      return UpdateStatus::used;
    }
    ++counts_.rejected;
    return UpdateStatus::disturbed;
  }

  /// None before there is an attitude.
  [[nodiscard]] std::optional<RadarInertialEstimate> estimate() const {
    if (!time_ || !ahrs_.ready()) return std::nullopt;
    const Vector9& x = filter_.state();
    return RadarInertialEstimate{*time_, x.head<3>(), x.segment<3>(3), ahrs_.q_world_body(),
                                 filter_.covariance().topLeftCorner<6, 6>()};
  }
  [[nodiscard]] const RadarInertialCounts& counts() const { return counts_; }  ///< so far
  [[nodiscard]] const Ahrs<frame::Enu>& ahrs() const { return ahrs_; }         ///< attitude

 private:
  using Vector9 = Eigen::Matrix<double, 9, 1>;
  using Matrix9 = Eigen::Matrix<double, 9, 9>;
  using Filter = Ekf<Vector9>;

  struct Step {
    Vector9 state;
    Matrix9 phi, q;
  };
  /// Predicted minus measured velocity.
  struct VelocityError {
    static constexpr int kDim = 3;
    Eigen::Vector3d velocity_m_s;
    Eigen::Matrix3d covariance;

    [[nodiscard]] Eigen::Vector3d error(const Vector9& x) const {
      return x.segment<3>(3) - velocity_m_s;
    }
  };

  [[nodiscard]] Matrix9 start_covariance() const {
    Vector9 sigma;
    sigma << Eigen::Vector3d::Constant(1e-3), Eigen::Vector3d::Constant(2.0),
        Eigen::Vector3d::Constant(o_.force_error_sigma);
    return sigma.cwiseAbs2().asDiagonal();
  }
  void predict(const ImuSample& s) {
    const double dt = to_seconds(s.time - *time_);
    rejected_for_s_ += dt;
    if (dt > o_.longest_gap_s) {
      ++counts_.gaps;
      rejected_for_s_ = o_.longest_rejection_s + dt;
    }
    const Eigen::Vector3d force =
        ahrs_.q_world_body() * s.specific_force_mps2 - Eigen::Vector3d(0.0, 0.0, o_.gravity_mps2);
    if (velocity_time_ && to_seconds(s.time - *velocity_time_) > o_.longest_gap_s)
      acceleration_mps2_.setZero();
    const double keep = std::exp(-dt / o_.force_error_time_s);
    filter_.predict([&](const Vector9& x) {
      Step step{x, Matrix9::Identity(), Matrix9::Zero()};
      const Eigen::Vector3d a = force - x.tail<3>();
      step.state.head<3>() += dt * (x.segment<3>(3) + 0.5 * dt * a);
      step.state.segment<3>(3) += dt * a;
      step.state.tail<3>() *= keep;
      step.phi.block<3, 3>(0, 3).diagonal().setConstant(dt);
      step.phi.block<3, 3>(0, 6).diagonal().setConstant(-0.5 * dt * dt);
      step.phi.block<3, 3>(3, 6).diagonal().setConstant(-dt);
      step.phi.block<3, 3>(6, 6).diagonal().setConstant(keep);
      const double unknown = dt > o_.longest_gap_s ? 1.0 : 0.0;  // m/s per √s
      step.q.diagonal().segment<3>(3).setConstant(o_.force_noise * o_.force_noise * dt +
                                                  unknown * dt);
      step.q.diagonal().tail<3>().setConstant(o_.force_error_sigma * o_.force_error_sigma *
                                              (1.0 - keep * keep));
      return step;
    });
  }
  /// Mean acceleration since the velocity before.
  void accelerate(const Eigen::Vector3d& velocity_m_s) {
    const double dt = velocity_time_ ? to_seconds(*time_ - *velocity_time_) : 0.0;
    if (dt > 0.0 && dt <= o_.longest_gap_s) {
      const double take = 1.0 - std::exp(-dt / o_.acceleration_time_s);
      acceleration_mps2_ += take * ((velocity_m_s - velocity_m_s_) / dt - acceleration_mps2_);
    } else if (dt > o_.longest_gap_s) {
      acceleration_mps2_.setZero();
    }
    velocity_m_s_ = velocity_m_s;
    velocity_time_ = time_;
  }
  /// Velocity of the unit in world axes.
  [[nodiscard]] VelocityError levelled(const RadarVelocity& v) const {
    const SO3d q = ahrs_.q_world_body();
    const Eigen::Vector3d of_unit =
        o_.q_unit_radar * v.velocity_m_s - rate_radps_.cross(o_.lever_m);
    const Eigen::Matrix3d r = (q * o_.q_unit_radar).matrix();
    Eigen::Matrix3d covariance = r * v.covariance * r.transpose();
    // Of the attitude, as far as it turns the velocity.
    const double turned =
        of_unit.squaredNorm() * ahrs_.world_covariance().topLeftCorner<2, 2>().trace();
    covariance.diagonal().array() += o_.velocity_sigma_m_s * o_.velocity_sigma_m_s + turned;
    return {q * of_unit, covariance};
  }

  RadarInertialOptions o_;
  Ahrs<frame::Enu> ahrs_;
  Filter filter_;
  std::optional<LogTime> time_;
  Eigen::Vector3d rate_radps_ = Eigen::Vector3d::Zero();
  // Of the last velocity accepted, and since the one before it; world axes.
  std::optional<LogTime> velocity_time_;
  Eigen::Vector3d velocity_m_s_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d acceleration_mps2_ = Eigen::Vector3d::Zero();
  double rejected_for_s_ = 0.0;
  RadarInertialCounts counts_;
};

/// A whole run, at the times of the velocities; both in order of time.
struct RadarInertialRun {
  std::vector<RadarInertialEstimate> estimates;  ///< one for each velocity after the start
  RadarInertialCounts counts;                    ///< of readings
};

/// Runs over recorded readings.
[[nodiscard]] inline RadarInertialRun run_radar_inertial(std::span<const ImuSample> unit,
                                                         std::span<const RadarVelocity> radar,
                                                         const RadarInertialOptions& options = {}) {
  RadarInertialOdometry odometry(options);
  RadarInertialRun run;
  std::size_t next = 0;
  for (const ImuSample& s : unit) {
    for (; next < radar.size() && radar[next].time < s.time; ++next) {
      (void)odometry.add(radar[next]);
      if (const auto e = odometry.estimate()) run.estimates.push_back(*e);
    }
    (void)odometry.add(s);
  }
  run.counts = odometry.counts();
  return run;
}

/// The same motion in reversed time: an inertial unit measures the opposite rates, and a radar the
/// opposite velocities; specific force is the same. Times are mirrored at `about`.
[[nodiscard]] inline std::vector<ImuSample> reversed_in_time(std::span<const ImuSample> unit,
                                                             LogTime about) {
  std::vector<ImuSample> back;
  for (std::size_t i = unit.size(); i-- > 0;)
    back.push_back(
        {about + (about - unit[i].time), -unit[i].angular_rate_radps, unit[i].specific_force_mps2});
  return back;
}
/// The same of velocities.
[[nodiscard]] inline std::vector<RadarVelocity> reversed_in_time(
    std::span<const RadarVelocity> radar, LogTime about) {
  std::vector<RadarVelocity> back(radar.rbegin(), radar.rend());
  for (RadarVelocity& v : back) {
    v.time = about + (about - v.time);
    v.velocity_m_s = -v.velocity_m_s;
  }
  return back;
}

}  // namespace wayfare
