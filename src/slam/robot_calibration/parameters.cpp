#include "slam/robot_calibration/parameters.hpp"

#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace wayfare {
namespace calibration {
namespace {

/// A row of the Jacobian of the reported parameters by those solved for.
using JacobianRow = Eigen::Matrix<double, 1, kRows>;

class Reporter {
 public:
  Reporter(RobotCalibration& result, const Solution& solution, const CalibrationLimits& limits)
      : result_(result), s_(solution), limits_(limits) {}

  void wheels(double given_base_m) {
    const Wheels& w = s_.values.wheels;
    add("wheels.left_scale", "", 1.0, w[0], unit_row(kWheels), limits_.wheel_scale);
    add("wheels.right_scale", "", 1.0, w[1], unit_row(kWheels + 1), limits_.wheel_scale);
    add("wheels.base", "m", given_base_m, w[2], unit_row(kWheels + 2), limits_.wheel_base * w[2]);
  }
  void mounting(const std::string& name, const SE2d& given, const SE2d& found, double delay_s,
                const Eigen::Matrix<double, 3, kRows>& by, const JacobianRow& delay) {
    const auto wrapped = given.heading() + (found.heading() - given.heading()).wrapped();
    add(name + ".x", "m", given.x(), found.x(), by.row(0), limits_.position_m);
    add(name + ".y", "m", given.y(), found.y(), by.row(1), limits_.position_m);
    add(name + ".yaw", "rad", given.heading().radians(), wrapped.radians(), by.row(2),
        limits_.yaw.radians());
    add(name + ".delay", "s", 0.0, delay_s, delay, limits_.delay_s);
  }
  /// Of a mounting's own right perturbation: in the base's axes.
  static Eigen::Matrix<double, 3, kRows> rows(const SE2d& mounting, Eigen::Index first) {
    Eigen::Matrix<double, 3, kRows> j = Eigen::Matrix<double, 3, kRows>::Zero();
    j.block<2, 2>(0, first) = mounting.rotation().matrix();
    j(2, first + 2) = 1.0;
    return j;
  }
  static JacobianRow unit_row(Eigen::Index at) {
    JacobianRow row = JacobianRow::Zero();
    row[at] = 1.0;
    return row;
  }
  void laser_to_radar(const SE2d& given) {
    const SE2d& laser = s_.values.laser;
    const SE2d found = laser.inverse() * s_.values.radar;
    // X_l⁻¹ X_r for right perturbations of both.
    Eigen::Matrix<double, 3, kRows> j = Eigen::Matrix<double, 3, kRows>::Zero();
    j.middleCols<3>(kLaser) = -found.inverse().adjoint();
    j.middleCols<3>(kRadar).setIdentity();
    j.topRows<2>() = (found.rotation().matrix() * j.topRows<2>()).eval();
    mounting("laser_to_radar", given, found, s_.values.radar_delay_s - s_.values.laser_delay_s, j,
             unit_row(kRadarDelay) - unit_row(kLaserDelay));
  }
  void gyro() {
    const GyroErrors& g = s_.values.gyro;
    add("gyro.scale", "", 1.0, g[0], unit_row(kGyro), limits_.gyro_scale);
    add("gyro.bias", "rad/s", 0.0, g[1], unit_row(kGyro + 1), limits_.gyro_bias_rad_s);
    add("gyro.delay", "s", 0.0, s_.values.gyro_delay_s, unit_row(kGyroDelay), limits_.delay_s);
  }
  void covariance() {
    const auto n = static_cast<Eigen::Index>(rows_.size());
    Eigen::Matrix<double, Eigen::Dynamic, kRows> j(n, Eigen::Index{kRows});
    for (Eigen::Index i = 0; i < n; ++i) j.row(i) = rows_[static_cast<std::size_t>(i)];
    result_.covariance = j * s_.covariance * j.transpose();
  }

 private:
  void add(std::string name, std::string unit, double given, double value, const JacobianRow& row,
           double limit) {
    const double sigma = std::sqrt((row * s_.covariance * row.transpose())(0, 0));
    const bool determined = sigma <= limit;
    // Beyond this a number would be the prior's.
    constexpr double kNothing = 10.0;
    result_.parameters.push_back(
        {std::move(name), std::move(unit), given, determined ? value : given,
         sigma <= kNothing * limit ? sigma : std::numeric_limits<double>::infinity(), determined});
    rows_.push_back(row);
  }

  RobotCalibration& result_;
  const Solution& s_;
  const CalibrationLimits& limits_;
  std::vector<JacobianRow> rows_;
};

}  // namespace

void fill(RobotCalibration& result, const Problem& p, const Solution& s, const Recording& r,
          const RobotCalibrationOptions& o) {
  Reporter report(result, s, o.limits);
  const SE2d laser = r.T_base_laser.raw(), radar = r.T_base_radar.raw();
  const SE2d T_laser_radar = laser.inverse() * radar;
  if (p.base.by_wheels()) {
    report.wheels(r.wheel_base_m);
    if (p.laser)
      report.mounting("laser", laser, s.values.laser, s.values.laser_delay_s,
                      Reporter::rows(s.values.laser, kLaser), Reporter::unit_row(kLaserDelay));
    if (p.radar)
      report.mounting("radar", radar, s.values.radar, s.values.radar_delay_s,
                      Reporter::rows(s.values.radar, kRadar), Reporter::unit_row(kRadarDelay));
    if (p.laser && p.radar) report.laser_to_radar(T_laser_radar);
  } else if (p.radar) {
    report.mounting("laser_to_radar", T_laser_radar, s.values.radar, s.values.radar_delay_s,
                    Reporter::rows(s.values.radar, kRadar), Reporter::unit_row(kRadarDelay));
  }
  if (p.gyro) report.gyro();
  report.covariance();
}

}  // namespace calibration

Recording RobotCalibration::applied_to(Recording r) const {
  const auto value = [&](const char* name, double otherwise) {
    const CalibratedParameter* p = find(name);
    return p != nullptr && p->determined ? p->value : otherwise;
  };
  const auto mounting = [&](const std::string& name, const SE2d& given) {
    return SE2d(value((name + ".x").c_str(), given.x()), value((name + ".y").c_str(), given.y()),
                Angle::radians(value((name + ".yaw").c_str(), given.heading().radians())));
  };
  const auto shift = [&](auto& stream, const char* name) {
    const Duration delay = from_seconds(value(name, 0.0));
    for (auto& measurement : stream) measurement.time = measurement.time - delay;
  };
  const bool by_wheels = find("wheels.base") != nullptr;
  const SE2d laser = mounting("laser", r.T_base_laser.raw());
  const SE2d radar =
      by_wheels ? mounting("radar", r.T_base_radar.raw())
                : laser * mounting("laser_to_radar", laser.inverse() * r.T_base_radar.raw());
  r.T_base_laser = Transform2<frame::Base, frame::Laser>(laser);
  r.T_base_radar = Transform2<frame::Base, frame::Radar>(radar);
  shift(r.scans, "laser.delay"), shift(r.gyro, "gyro.delay");
  shift(r.radar, by_wheels ? "radar.delay" : "laser_to_radar.delay");
  const double scale = value("gyro.scale", 1.0), bias = value("gyro.bias", 0.0);
  for (GyroSample& g : r.gyro) g.turn_rate_rad_s = (g.turn_rate_rad_s - bias) / scale;
  if (!by_wheels || !(r.wheel_base_m > 0.0 || find("wheels.base")->determined)) return r;
  r.wheel_base_m = value("wheels.base", r.wheel_base_m);
  const double left = value("wheels.left_scale", 1.0), right = value("wheels.right_scale", 1.0);
  for (WheelSample& w : r.wheels) w.left_m *= left, w.right_m *= right;
  r.odometry.clear();
  SE2d pose;
  for (const WheelSample& w : r.wheels) {
    pose = pose.plus({0.5 * (w.left_m + w.right_m), 0.0, (w.right_m - w.left_m) / r.wheel_base_m});
    r.odometry.push_back({w.time, Transform2<frame::Odom, frame::Base>(pose)});
  }
  return r;
}

}  // namespace wayfare
