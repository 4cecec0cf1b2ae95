#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>

#include <Eigen/Cholesky>

#include <wayfare/nav/gnss_ins.hpp>

#include "nav/gnss_ins/coarse_start.hpp"
#include "nav/gnss_ins/receiver_clocks.hpp"
#include "nav/gnss_ins/zero_velocity_detector.hpp"

namespace wayfare::nav {

/// Antenna position and velocity by least squares on one epoch.
struct RangeSolution {
  Eigen::Vector3d position_ecef_m = Eigen::Vector3d::Zero();
  double position_sigma_m = 0.0;  ///< the worst axis
  std::optional<Eigen::Vector3d> velocity_ecef_mps;
};

inline std::optional<Eigen::Vector3d> solve_velocity(const RangeEpoch& epoch,
                                                     const Eigen::Vector3d& position) {
  Eigen::Matrix4d a = Eigen::Matrix4d::Zero();
  Eigen::Vector4d b = Eigen::Vector4d::Zero();
  int count = 0;
  for (const CorrectedRange& s : epoch.satellites) {
    if (!has_range(s) || !has_rate(s)) continue;
    const Eigen::Vector3d u = (s.position_ecef_m - position).normalized();
    const Eigen::Vector4d row(-u.x(), -u.y(), -u.z(), 1.0);
    const double weight = 1.0 / (s.range_rate_sigma_mps * s.range_rate_sigma_mps);
    a += weight * row * row.transpose();
    b += weight * row * (s.range_rate_mps - u.dot(s.velocity_ecef_mps));
    ++count;
  }
  const Eigen::LLT<Eigen::Matrix4d> llt(a);
  if (count < 4 || llt.info() != Eigen::Success) return std::nullopt;
  const Eigen::Vector3d v = llt.solve(b).head<3>();
  return v.allFinite() ? std::optional(v) : std::nullopt;
}

/// Plain least squares for position and one clock per system; none for too few or inconsistent
/// ranges.
[[nodiscard]] inline std::optional<RangeSolution> solve_ranges(const RangeEpoch& epoch) {
  constexpr int kUnknowns = 3 + kGnssSystems;
  using Unknowns = Eigen::Matrix<double, kUnknowns, 1>;
  using Normal = Eigen::Matrix<double, kUnknowns, kUnknowns>;
  RangeSolution r;
  Unknowns x = Unknowns::Zero();
  for (int round = 0; round < 12; ++round) {
    Normal a = Normal::Zero();
    Unknowns b = Unknowns::Zero();
    int count = 0;
    for (const CorrectedRange& s : epoch.satellites) {
      if (!has_range(s)) continue;
      const Eigen::Vector3d to = s.position_ecef_m - r.position_ecef_m;
      const int clock = 3 + static_cast<int>(s.satellite.system);
      Unknowns row = Unknowns::Zero();
      row.head<3>() = -to.normalized();
      row[clock] = 1.0;
      a += row * row.transpose() / (s.range_sigma_m * s.range_sigma_m);
      b += row * (s.range_m - to.norm() - x[clock]) / (s.range_sigma_m * s.range_sigma_m);
      ++count;
    }
    if (count < 4) return std::nullopt;
    // The clocks of unobserved systems are fixed at zero.
    a.diagonal() = (a.diagonal().array() == 0.0).select(1.0, a.diagonal());
    const Eigen::LLT<Normal> llt(a);
    if (llt.info() != Eigen::Success) return std::nullopt;
    const Unknowns step = llt.solve(b);
    if (!step.allFinite()) return std::nullopt;
    r.position_ecef_m += step.head<3>();
    x.tail<kGnssSystems>() += step.tail<kGnssSystems>();
    if (step.head<3>().norm() > 0.01) continue;
    const Eigen::Matrix3d covariance = llt.solve(Normal::Identity()).topLeftCorner<3, 3>();
    r.position_sigma_m = std::sqrt(covariance.diagonal().maxCoeff());
    const double radius = r.position_ecef_m.norm();
    if (!(r.position_sigma_m < 200.0) || radius < 6.2e6 || radius > 6.6e6) return std::nullopt;
    r.velocity_ecef_mps = solve_velocity(epoch, r.position_ecef_m);
    return r;
  }
  return std::nullopt;
}

/// Collects the initial state: position, heading from velocity, tilt from inertial readings.
class Starter {
 public:
  explicit Starter(const GnssInsOptions& options) : options_(options) {}

  void add(const ImuSample& sample) {
    const double dt = last_ ? to_seconds(sample.time - last_->time) : 0.0;
    if (dt > 1.0) recent_.forget();
    recent_.add(sample, std::min(dt, 1.0));
    last_ = sample;
    // Standing by GNSS velocity, and not being handled or boarded.
    if (!standing_ || !recent_.full() || recent_.force_spread_mps2() > 0.3) return;
    standing_rate_sum_ += sample.angular_rate_radps;
    standing_s_ += std::min(dt, 1.0);
    ++standing_count_;
  }

  /// The receiver's own solution; none for too few ranges.
  [[nodiscard]] static std::optional<StartPosition> position_of(const RangeEpoch& epoch) {
    const auto solved = solve_ranges(epoch);
    if (!solved) return std::nullopt;
    const Geodetic antenna = geodetic_from_ecef(solved->position_ecef_m);
    StartPosition p{epoch.time, antenna, solved->position_sigma_m, std::nullopt};
    if (solved->velocity_ecef_mps)
      p.velocity_ned_mps = rotation_ecef_ned(antenna).transpose() * *solved->velocity_ecef_mps;
    return p;
  }
  [[nodiscard]] static std::optional<StartPosition> position_of(const GnssFix& fix) {
    const double sigma = std::sqrt(fix.position_covariance_ned_m2.diagonal().maxCoeff());
    return StartPosition{fix.time, fix.position, sigma, fix.velocity_ned_mps};
  }
  /// Least standard deviation of a start's position, m.
  [[nodiscard]] static double least_sigma_m(const RangeEpoch&) { return 3.0; }
  [[nodiscard]] static double least_sigma_m(const GnssFix&) { return 0.5; }

  template <class Gnss>
  [[nodiscard]] std::optional<GnssInsStart> add(const Gnss& m,
                                                const std::optional<StartPosition>& p) {
    ++epochs_;
    if (!p) return std::nullopt;
    ++positions_;
    // A position alone determines neither standstill nor heading.
    if (!p->velocity_ned_mps) return std::nullopt;
    ++velocities_;
    return try_start(m.time, p->antenna, *p->velocity_ned_mps,
                     std::max(least_sigma_m(m), sigmas_of_start(options_) * p->sigma_m));
  }

  /// What is missing, and what would help.
  [[nodiscard]] std::string missing() const {
    char text[320] = "";
    const double force = recent_.mean_force_mps2().norm();
    if (!last_) return "there are no usable inertial readings";
    if (epochs_ == 0)
      return "there is no receiver's measurement within the inertial readings: their clocks differ "
             "(imu_time_offset_s)";
    if (positions_ == 0)
      std::snprintf(text, sizeof text,
                    "none of %d epochs gives a position: at least four satellites are needed (a "
                    "navigation file of the day, elevation_mask_deg, min_cn0_dbhz)",
                    epochs_);
    else if (near_ == 0 && velocities_ > 0)
      std::snprintf(text, sizeof text,
                    "no velocity of the receiver is within a second of full inertial readings: "
                    "their clocks differ (imu_time_offset_s), or the readings have gaps");
    else if (force < 5.0 || force > 20.0)
      std::snprintf(text, sizeof text,
                    "the specific force is %.3g m/s\u00b2 in place of about 9.8: the unit of the "
                    "accelerometers (columns ax ay az, accel_factor)",
                    force);
    else if (velocities_ == 0)
      std::snprintf(text, sizeof text,
                    "none of %d positions has a velocity (no Doppler), and there is no straight "
                    "on which their differences give one, nor a rest of %d s: give Doppler or "
                    "\"start\" in the description",
                    positions_, 10);
    else
      std::snprintf(text, sizeof text,
                    "the fastest of %d velocities is %.2f m/s: the heading needs start_speed_mps "
                    "(%.2f m/s) in two epochs that agree, or \"start\" in the description",
                    velocities_, fastest_mps_, options_.start_speed_mps);
    return text;
  }

 private:
  /// Earth rate, which is part of the mean at rest, and residual engine vibration.
  static constexpr double kBiasAtRestSigma_radps = 3e-4;

  struct VelocityFix {
    LogTime time;
    Eigen::Vector3d velocity_ned_mps;
  };
  [[nodiscard]] std::optional<GnssInsStart> try_start(LogTime time, const Geodetic& antenna,
                                                      const Eigen::Vector3d& v,
                                                      double position_sigma_m) {
    const std::optional<VelocityFix> before = before_;
    before_ = VelocityFix{time, v};
    standing_ = v.norm() < 0.3;
    const double speed = std::hypot(v.x(), v.y());
    fastest_mps_ = std::max(fastest_mps_, speed);
    if (recent_.full() && last_ && std::abs(to_seconds(time - last_->time)) <= 1.0) ++near_;
    if (!recent_.full() || speed < options_.start_speed_mps || speed > 200.0) return std::nullopt;
    if (!last_ || std::abs(to_seconds(time - last_->time)) > 1.0) return std::nullopt;
    // Two consecutive velocities must agree, so that one bad epoch does not start the filter.
    if (!before) return std::nullopt;
    const double dt = to_seconds(time - before->time);
    if (dt <= 0.0 || dt > 2.5) return std::nullopt;
    const Eigen::Vector3d a = (v - before->velocity_ned_mps) / dt;
    if (a.norm() > 8.0) return std::nullopt;

    const double heading = std::atan2(v.y(), v.x());
    const double c = std::cos(heading), s = std::sin(heading);
    const Eigen::Vector3d force(c * a.x() + s * a.y(), -s * a.x() + c * a.y(),
                                a.z() - wgs84::kEquatorGravity_mps2);
    const Eigen::Vector3d measured = options_.q_body_imu * recent_.mean_force_mps2();
    const double across = std::hypot(measured.y(), measured.z());
    if (across < 1.0 || std::abs(force.y()) > across) return std::nullopt;
    const double roll = std::asin(force.y() / across) - std::atan2(measured.y(), -measured.z());
    const double down = std::sin(roll) * measured.y() + std::cos(roll) * measured.z();
    const double pitch =
        wrap_to_pi(std::atan2(force.x(), force.z()) - std::atan2(measured.x(), down));
    const auto rotation = [](int axis, double angle) {
      return SO3d::exp(angle * Eigen::Vector3d::Unit(axis));
    };

    GnssInsStart start;
    start.nav.time = time;
    start.nav.q_nb = rotation(2, heading) * rotation(1, pitch) * rotation(0, roll);
    start.nav.velocity_ned_mps = v;
    start.nav.position =
        geodetic_from_ned(-(start.nav.q_nb * options_.antenna_lever_arm_m), antenna);
    start.position_sigma_m = position_sigma_m;
    start.velocity_sigma_mps = 0.5;
    start.level_sigma_rad = 0.05;
    start.heading_sigma_rad = options_.start_heading_sigma_rad;
    if (standing_s_ > 5.0) {
      start.gyro_bias_radps = standing_rate_sum_ / standing_count_;
      start.gyro_bias_sigma_radps = kBiasAtRestSigma_radps;
    }
    return start;
  }

  GnssInsOptions options_;
  RecentReadings recent_;
  std::optional<ImuSample> last_;
  std::optional<VelocityFix> before_;
  bool standing_ = false;  ///< by the latest GNSS velocity
  Eigen::Vector3d standing_rate_sum_ = Eigen::Vector3d::Zero();
  int standing_count_ = 0;
  double standing_s_ = 0.0;
  int epochs_ = 0, positions_ = 0, velocities_ = 0;
  int near_ = 0;  ///< velocities beside inertial readings
  double fastest_mps_ = 0.0;
};

}  // namespace wayfare::nav
